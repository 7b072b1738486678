#!/usr/bin/env python3
"""Builds the fuzzers of the readers with clang and runs each for some seconds; what breaks one is
kept and told.

Usage: fuzz.py BUILD SECONDS [READER ...] [--keep]

The sources that read are compiled with libFuzzer and the address and undefined-behaviour
sanitizers, the rest is taken from the libspall.a of BUILD. Inputs begin from tests/corpus.txt and
those kept in tests/fuzz/corpus, one archive a reader; --keep puts the smallest set of inputs that
reaches as much there.
"""
import concurrent.futures
import json
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import zipfile

here = pathlib.Path(__file__).resolve().parent
root = here.parents[1]
compiler = "clang++-14"
sanitize = ["-fsanitize=address,undefined", "-fno-sanitize-recover=undefined", "-O1", "-g1"]
instrumented = ["keys/section", "keys/toml_text", "keys/units", "output/fclib", "output/h5",
                "output/restart",
                "output/seal", "output/series", "output/stored_bodies", "scene/case",
                "scene/materials",
                "scene/read_group", "scene/read_motion", "scene/read_walls", "scene/sizes",
                "scene/surface_mesh"]
readers = {  # and the bases of tests/corpus.txt that they begin from
    "units": [],
    "cases": ["rigid", "grains", "molecules", "solid", "mesh", "stored"],
    "meshes": ["mesh"],
    "stored": ["stored"],
    "contacts": ["contacts"],
    "restarts": ["restart"],
    "seals": [],
    "series": [],
}
suffix = {"cases": "x.toml", "meshes": "rock.obj", "stored": "pile.h5", "contacts": "x.h5",
          "restarts": "x.h5"}
longest = 4096  # bytes of an input


def commands(build):
    """How each source is compiled, without the compiler, its own options and precompiled
    headers."""
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])
        words = iter(words[next(k for k, word in enumerate(words) if word.startswith("-")):])
        kept = []
        for word in words:
            if word in ("-include", "-o", "-c"):
                next(words)
            elif not word.startswith(("-W", "-O", "-f", "-g", "-D_FORTIFY")):
                kept.append(word)
        yield pathlib.Path(entry["file"]), kept


def compile_all(build, out):
    """The objects of the sources that read, and one program."""
    options = dict(commands(build))
    sources = [root / f"src/{name}.cpp" for name in instrumented] + [here / "readers.cpp"]
    objects = [out / f"{source.stem}.o" for source in sources]
    flags = options[root / "src/output/h5.cpp"]

    headers = [here.parent / "described_hdf5.hpp", *root.glob("src/*/*.hpp"),
               *root.glob("include/spall/*.hpp")]

    def make(source, target):
        newest = max(path.stat().st_mtime for path in [source, *headers])
        if not target.exists() or target.stat().st_mtime < newest:
            subprocess.run([compiler, *sanitize, "-fsanitize=fuzzer-no-link", *flags, "-c",
                            str(source), "-o",
                            str(target)], check=True)

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(make, sources, objects))
    libraries = subprocess.run(["pkg-config", "--libs", "petsc", "hdf5-openmpi", "ompi-c",
                                "tomlplusplus", "fmt"],
                               check=True, capture_output=True, text=True).stdout.split()
    subprocess.run([compiler, *sanitize, "-fsanitize=fuzzer", *map(str, objects),
                    str(build / "libspall.a"),
                    *libraries, "-lmetis", "-ldl", "-o", str(out / "readers")], check=True)


def bases():
    """The files of tests/corpus.txt by base and name, as they are accepted."""
    files, base, file = {}, None, None
    for line in (here.parent / "corpus.txt").read_text().splitlines():
        if line.startswith("== "):
            base, file = (None if line == "== changes" else line.split()[1]), None
        elif base and line.startswith("-- "):
            file = (base, line[3:])
            files[file] = ""
        elif file:
            files[file] += line + "\n"
    return files


def fuzz(name, out, seconds, keep):
    """Runs one reader; true where it held."""
    found, seeds, own, kept = (out / f"{name}_{what}" for what in ("found", "seeds", "own", "kept"))
    for folder in (found, seeds, own):
        folder.mkdir(exist_ok=True)
    for base in readers[name]:
        (seeds / base).write_text(bases()[base, suffix[name]])
    archive = here / "corpus" / f"{name}.zip"
    if archive.exists():
        zipfile.ZipFile(archive).extractall(own)
    environment = os.environ | {"ASAN_OPTIONS": "detect_leaks=0:allocator_may_return_null=0:"
                                                "detect_odr_violation=0",
                                "SPALL_READER": name, "OMPI_ALLOW_RUN_AS_ROOT": "1",
                                "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    limits = [f"-max_len={longest}", "-timeout=10", "-rss_limit_mb=3000", "-malloc_limit_mb=1000"]
    run = subprocess.run([str(out / "readers"), f"-max_total_time={seconds}",
                          "-print_final_stats=1", *limits,
                          f"-artifact_prefix={out}/{name}_", str(found), str(own), str(seeds)],
                         env=environment, capture_output=True, text=True, errors="replace")
    executed = [line.split()[-1] for line in run.stderr.splitlines()
                if "number_of_executed_units" in line]
    print(f"{name}: {executed[0] if executed else '?'} inputs in {seconds} s, "
          f"{'all read or refused' if run.returncode == 0 else 'BROKEN'}", flush=True)
    if run.returncode != 0:
        print(run.stderr[-6000:])
    if keep:
        shutil.rmtree(kept, ignore_errors=True)
        kept.mkdir()
        subprocess.run([str(out / "readers"), "-merge=1", *limits, str(kept), str(own), str(found),
                        str(seeds)],
                       env=environment, capture_output=True, check=True)
        archive.parent.mkdir(exist_ok=True)
        with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
            for path in sorted(kept.iterdir()):
                file.writestr(zipfile.ZipInfo(path.name), path.read_bytes(), zipfile.ZIP_DEFLATED)
    return run.returncode == 0


def main():
    words = [w for w in sys.argv[1:] if w != "--keep"]
    build, seconds, names = pathlib.Path(words[0]).resolve(), int(words[1]), words[2:] or list(
        readers)
    out = build / "fuzz"
    out.mkdir(exist_ok=True)
    compile_all(build, out)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        held = list(pool.map(lambda name: fuzz(name, out, seconds, "--keep" in sys.argv), names))
    sys.exit(0 if all(held) else 1)


main()
