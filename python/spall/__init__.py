"""Spall: impacts, piles and grains made of many spheres, on MPI ranks.

    import spall
    run = spall.run("cases/hello/case.toml", out="out/hello", set={"seed": 2})
    print(run["deflection"]["beta"], run.series.kinetic.iloc[-1])

or step by step:

    sim = spall.Simulation("cases/hello/case.toml")
    sim.run_until(3600)
    print(sim.energies(), sim.bodies.position.mean(axis=0))

All calls but those of Run are collective: under `mpirun -n 4 python3 program.py` each rank makes
them and has its own share of the bodies.
"""
import atexit
import sys
import traceback

from spall import _spall
from spall._spall import Error
from spall.results import Run
from spall.toml import overrides_of, to_toml

__version__ = _spall.version
__all__ = ["Bodies", "Error", "Run", "Scene", "Simulation", "check", "draw", "rank", "ranks",
           "resume", "run"]

atexit.register(_spall.end)


def _end_all_ranks(kind, error, trace, own_hook=sys.excepthook):
    """What nobody catches ends all ranks: others would wait for this one for ever."""
    _spall.end_others("".join(traceback.format_exception(kind, error, trace)).rstrip())
    own_hook(kind, error, trace)


sys.excepthook = _end_all_ranks


def rank():
    """The number of this rank, 0 of a program without mpirun."""
    return _spall.rank()


def ranks():
    """How many ranks there are."""
    return _spall.ranks()


class Scene:
    """What a case says, and spheres that are added to it.

    `case`: the path of a TOML file, the text of one, or nothing where all tables are given by name,
    as
    Scene(materials={"rock": {"density": 2000}}, phases=[{"name": "fall", "step": 1e-3, "duration":
    1}]).
    `set`: keys to change, {"contact.friction": 0.3}. Numbers are SI, texts may carry units: "1
    km/s".
    """

    def __init__(self, case=None, set=None, **tables):
        if case is None:
            self._scene = _spall.Scene.from_text(to_toml(tables), overrides_of(set))
        elif tables:
            raise TypeError(
                f"a case and tables of one: {', '.join(tables)}; `set` changes single keys")
        elif "\n" in str(case):
            self._scene = _spall.Scene.from_text(case, overrides_of(set))
        else:
            self._scene = _spall.Scene.from_file(str(case), overrides_of(set))

    def add(self, material, radius, mass=0, position=(0, 0, 0), velocity=(0, 0, 0), spin=(0, 0, 0),
            fixed=False):
        """A sphere (m, kg, m/s, rad/s); without a mass, by the density of its material. Its id is
        the next."""
        self._scene.add(material, radius, mass, position, velocity, spin, fixed)
        return self

    def check(self):
        """What the scene makes and runs, in words. Raises Error where a run of it would."""
        return self._scene.check()

    def run(self, out, overwrite=False):
        """Runs it to its end and writes the files of `spall run` into the folder `out`; returns its
        Run. A signal that ends it, such as Ctrl-C, leaves a restart file and raises
        KeyboardInterrupt."""
        return _run_of(self._scene.run(str(out), overwrite), out)


def _run_of(ended, out):
    if not ended:
        raise KeyboardInterrupt(f"stopped by a signal; spall.resume('{out}/restart.h5') goes on")
    return Run(out)


class Bodies:
    """This rank's bodies: each field of `spall keys` as a NumPy array, its rows the owned bodies.

    The arrays are the simulation's own memory. They hold until its next step, when bodies may move
    to other rows and ranks: ask for them again then, or copy them. Ids stay. What is asked for is
    the present state, whenever this was got.
    """

    def __init__(self, fields):
        object.__setattr__(self, "_fields", fields)

    def __setattr__(self, name, value):
        raise AttributeError(
            f"bodies.{name} = ... would change no body: in change_bodies write bodies.{name}[:] = "
            f"...")

    def __getattr__(self, name):
        if name.startswith("_"):  # what copy looks for before there are fields
            raise AttributeError(name)
        values = self._fields.get(name)
        if values is None:
            raise AttributeError(
                f"bodies have no {name}; they have {', '.join(self._fields.names())}")
        return values

    def __dir__(self):
        return self._fields.names()

    def __len__(self):
        return len(self._fields)

    def frame(self):
        """A pandas frame of copies, by id."""
        import pandas
        columns = {}
        for name in self._fields.names():
            values = self._fields.get(name)
            if values.ndim == 2:
                axes = "xyzw"[:values.shape[1]]
                columns.update({f"{name}_{axis}": values[:, k].copy()
                                for k, axis in enumerate(axes)})
            else:
                columns[name] = values.copy()
        return pandas.DataFrame(columns).set_index("id").sort_index()


class _Copies:
    """Fields while a program changes them: copies, which become the bodies' when its call returns.

    A view into the simulation would stay writable for whoever kept it, past checks and booking.
    """

    def __init__(self, fields):
        self._fields, self._copies = fields, {}

    def names(self):
        return self._fields.names()

    def __len__(self):
        return len(self._fields)

    def get(self, name):
        values = self._fields.get(name)
        if self._copies is None or values is None or not values.flags.writeable:
            return values
        if name not in self._copies:
            self._copies[name] = values.copy()
        return self._copies[name]

    def write_back(self):
        for name, values in self._copies.items():
            self._fields.get(name)[:] = values

    def end_call(self):
        """From now on the fields are the simulation's, read-only; what was kept changes nothing."""
        for values in self._copies.values():
            values.setflags(write=False)
        self._copies = None


class Simulation:
    """A scene on its way through time, without files. Takes a Scene, or what a Scene takes."""

    def __init__(self, case=None, set=None, **tables):
        if isinstance(case, Scene) and (set or tables):
            raise TypeError("a Scene is made already: `set` and tables are given to Scene")
        self._scene = case if isinstance(case, Scene) else Scene(case, set, **tables)
        self._made = None
        self._bodies = None

    def add(self, *args, **sphere):
        """As Scene.add; before the first question or step."""
        if self._made:
            raise Error("spheres are added before a simulation begins")
        self._scene.add(*args, **sphere)
        return self

    @property
    def _simulation(self):
        if self._made is None:
            self._made = _spall.Simulation(self._scene._scene)
        return self._made

    @property
    def time(self):
        """s since the start."""
        return self._simulation.time

    @property
    def steps(self):
        """Made since the start."""
        return self._simulation.steps

    @property
    def phase(self):
        """The name of the present phase."""
        return self._simulation.phase

    @property
    def over(self):
        """Whether all phases are over."""
        return self._simulation.over

    @property
    def bodies(self):
        if self._bodies is None:
            self._bodies = Bodies(self._simulation.bodies())
        return self._bodies

    def step(self, most=1):
        """One step, or up to `most` where forces are smooth; a dict of how many, contacts,
        residual, overlap."""
        return self._simulation.step(most)

    def run_until(self, time, each=None, steps=1):
        """Steps until `time` (s) is reached or all phases are over; `each(simulation)` is called
        after each `steps` steps. `over` tells whether the phases ended first."""
        if each is None and steps != 1:
            raise ValueError("run_until: steps tells how often to call each, which is not given")
        if steps != int(steps) or steps < 1:
            raise ValueError(
                f"run_until: each after {steps} steps is asked for; a whole number is wanted")
        left = steps

        def after_step():
            nonlocal left
            left -= 1
            if left == 0:
                left = steps
                each(self)

        self._simulation.run_until(time, after_step if each else None)
        return self

    def energies(self):
        """J over all ranks: kinetic, pairs, gravitational, dissipated, own_work,
        prescribed_work."""
        return self._simulation.energies()

    def pairs(self):
        """Ids of bodies that touch, are within the range of cohesion or are bound: an array of two
        columns."""
        return self._simulation.pairs()

    def change_bodies(self, change):
        """Calls `change(bodies)`, whose arrays may be written; the energy that it gives is
        booked. They are copies, which the bodies take over when the call returns."""
        def on_copies(fields):
            copies = _Copies(fields)
            try:
                change(Bodies(copies))
                copies.write_back()
            finally:
                copies.end_call()

        self._simulation.change_bodies(on_copies)
        return self

    def add_force(self, force):
        """From now on `force(bodies, forces)` adds to the force (N) on each owned body, row by
        row. What it returns would not be used: anything but None is refused."""
        def add(fields, of_step):
            forces = of_step.copy()  # may be kept; those of the step are gone after it
            if force(Bodies(fields), forces) is not None:
                raise TypeError("add_force: write into forces, as in forces[:] += ...; what the "
                                "function returns is not used")
            of_step[:] = forces

        self._simulation.add_force(add)
        return self

    def draw(self, file=None, **how):
        """A picture of this rank's bodies; see spall.draw."""
        return draw(self.bodies, file, **how)


def check(case, set=None):
    """What `spall check` prints."""
    return Scene(case, set).check()


def run(case, out, set=None, overwrite=False):
    """Runs a case to its end, as `spall run` does, and returns its Run."""
    return Scene(case, set).run(out, overwrite)


def resume(restart, out="", set=None, overwrite=False, stored_case=False):
    """Goes on from a restart file, as `spall resume` does, and returns the Run. `stored_case`: with
    the case as it was, whatever its file says by now."""
    from pathlib import Path
    out = out or Path(restart).parent
    return _run_of(
        _spall.resume(str(restart), str(out), overwrite, overrides_of(set), stored_case), out)


def draw(bodies, file=None, along="y", colour=None, size=6):
    """Draws spheres as seen along an axis; `colour`: an array, one value a body, else speeds.
    Returns the figure."""
    from spall.picture import draw_spheres
    return draw_spheres(bodies, file, along, colour, size)
