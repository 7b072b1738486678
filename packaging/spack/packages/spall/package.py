# How Spack builds Spall from the tree in which this file lies.
# SPDX-License-Identifier: BSD-3-Clause
import os

from spack.package import *


class Spall(CMakePackage):
    """Hypervelocity impacts of bodies made of many spheres, on MPI ranks."""

    git = "file://" + os.path.realpath(os.path.join(os.path.dirname(__file__), *[".."] * 4))

    license("BSD-3-Clause")

    version("main", branch="main")

    generator("ninja")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("python@3.11:", type=("build", "run"))
    depends_on("mpi")
    depends_on("petsc@3.18:~complex+mpi")
    depends_on("hdf5+mpi")
    depends_on("metis@5.1:")
    depends_on("eigen@3.4:")
    depends_on("fmt@9:")
    depends_on("cli11@2.3:")
    depends_on("tomlplusplus@3.3:")
    # What `spall report` draws with.
    depends_on("py-numpy", type="run")
    depends_on("py-h5py", type="run")
    depends_on("py-matplotlib", type="run")

    conflicts("%gcc@:11", msg="the kernels want GCC 12 or Clang 14")

    def cmake_args(self):
        return [self.define("SPALL_TESTS", False), self.define("SPALL_BENCH", False)]
