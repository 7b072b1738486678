"""What a run left in its folder."""
from functools import cached_property
from pathlib import Path


class Run:
    """run["deflection"]["beta"] is a result; run.series a pandas frame; run.frames() yields the
    bodies through time."""

    def __init__(self, folder):
        self.folder = Path(folder)
        if not self.folder.is_dir():
            raise FileNotFoundError(f"{folder} is no folder of a run")

    @cached_property
    def results(self):
        """results.toml as a dict, read once."""
        import tomllib
        return tomllib.loads((self.folder / "results.toml").read_text())

    def __getitem__(self, section):
        return self.results[section]

    @property
    def series(self):
        """series.csv: a row an instant."""
        import pandas
        return pandas.read_csv(self.folder / "series.csv")

    def frames(self):
        """(time, {field: array}) of each frame of trajectory.h5."""
        import h5py
        with h5py.File(self.folder / "trajectory.h5") as file:
            bodies = file["particles/all"]
            moving = {name: bodies[name] for name in bodies if isinstance(bodies[name], h5py.Group)
                      and "value" in bodies[name]}
            fixed = {name: bodies[name][()] for name in bodies
                     if isinstance(bodies[name], h5py.Dataset)}
            times = moving["position"]["time"][()]
            for k, time in enumerate(times):
                yield float(time), {**fixed,
                                    **{name: group["value"][k] for name, group in moving.items()}}

    def report(self):
        """Makes report.html, as `spall report` does, and returns its path."""
        import subprocess
        import sys
        beside = Path(sys.executable).parent / "spall"  # where pip puts it, in PATH or not
        subprocess.run([beside if beside.is_file() else "spall", "report", str(self.folder)],
                       check=True)
        return self.folder / "report.html"

    def __repr__(self):
        return f"spall.Run({str(self.folder)!r})"
