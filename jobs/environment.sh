# Sourced by the other scripts: what Open MPI wants where it runs as root, as in a container.
if [ "$(id -u)" -eq 0 ]; then
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi
cd "$(dirname "${BASH_SOURCE[0]}")/.."
