# The command line of `spall watch`.
# SPDX-License-Identifier: BSD-3-Clause
"""Shows a run while it goes on: open the address that is printed in a browser. Ctrl-C ends it; the
run does not notice.

  spall watch out/hello
"""
import argparse
import signal

from system_python import need


def main():
    parser = argparse.ArgumentParser("spall watch", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="folder that a run writes")
    parser.add_argument("--port", type=int, default=8710,
                        help="of 127.0.0.1 (default: %(default)s; 0: any that is free)")
    options = parser.parse_args()
    if not 0 <= options.port < 65536:
        parser.exit(1, f"spall watch: --port = {options.port}: 0 to 65535 is wanted\n")
    # Also where a shell began this in the background.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    need("spall watch", "h5py", "numpy")
    from report_server import serve
    serve(options.folder, options.port)


if __name__ == "__main__":
    main()
