# What a run's results say of its worth, a plain sentence each. docs/report.md tells what each
# means.
# SPDX-License-Identifier: BSD-3-Clause
from report_run import readable_time

GOOD, NOTE, BAD = "good", "note", "bad"
ROUND_OFF = 1e-9  # of three spacings; of the impactor's momentum, the drift that sums make
# Drift of angular momentum that gravity's tree may make: the default of its accuracy.
OF_A_TREE = 1e-4
ENERGY_CLOSED, ENERGY_OPEN = 0.01, 0.05  # unexplained, of what was dissipated or moves
NEXT_TO_NOTHING = 1e-6  # dissipated, of the kinetic energy; as src/run/account.cpp has it
SAME_BETA = 0.02  # beta within this of 1 + e is taken for it
STILL_RISING = 0.02  # of dv between the last two read-outs
YET_TO_COME = 0.01  # of the energy that flies at a wall, beyond which its verdict is not final
STILL_FAILING = 0.05  # of the margin between the last two times at which it was judged
FEW_LAYERS = 3  # of bodies in a wall, fewer than which tell little of it
LARGE_OVERLAP = 0.01  # of the smaller radius: rigid bodies should have none
SOFT_OVERLAP = 0.01  # the same: until there a low stiffness changes little


def verdicts(run):
    """(grade, sentence) of each question that the run has an answer to."""
    results = run.results
    found = [ended(run)]
    if results:
        found += [*shields(results), converged(results), *books(results),
                  *told_by_the_run(results), *beta(results), rising(results)]
    found.append(overlaps(run))
    return [one for one in found if one]


def ended(run):
    time = run.series["time"]
    reached = readable_time(time[-1]) if len(time) else "the start"
    if run.results:
        return GOOD, f"The run has ended; its last row stands at {reached}."
    if run.under_way:
        return NOTE, f"The run is under way and has reached {reached}: there are no results yet."
    return BAD, (f"The run has not ended: it stopped after {reached} and can be resumed. There are "
                 f"no results yet.")


def shields(results):
    """What became of each wall that the case asks a verdict of."""
    for wall in (table for section, table in results.items() if section.startswith("shield_")):
        # A group that is called "wall", as most are, is not named twice.
        name = wall["wall"] if "wall" in wall["wall"] else f"wall {wall['wall']}"
        thickness, found = 1e3 * wall["thickness"], wall["verdict"]
        if found == "held":
            yield GOOD, (f"The {name} has held: where it is thinnest, {percent(wall['margin'])} "
                         f"of its {thickness:.3g} mm are left.")
        elif found == "perforated":
            holes = "an opening" if wall["openings"] == 1 else f"{wall['openings']} openings"
            yield NOTE, (f"The {name} is perforated: it has {holes} of up to "
                         f"{1e3 * wall['hole']:.3g} mm.")
        else:
            yield NOTE, (f"Spall has detached from the {name}: {1e3 * wall['spall_mass']:.2g} g "
                         f"in {wall['spall_pieces']} pieces leave its rear at "
                         f"{wall['spall_speed']:.3g} m/s.")
        if wall["still_coming"] > YET_TO_COME and found != "perforated":
            yield NOTE, (f"The verdict on the {name} is not final: {percent(wall['still_coming'])} "
                         "of the energy that flies at it has not met it yet. A longer run may give "
                         "another.")
        if len(margins := wall["margins"]) > 1:
            before, after = margins[-2:]
            times = [readable_time(time) for time in wall["times"][-2:]]
            if abs(after - before) > STILL_FAILING * abs(after):
                yield NOTE, (f"The margin of the {name} still changed from {before:.3g} to "
                             f"{after:.3g} of its thickness between {times[0]} and {times[1]}: "
                             "a longer run may give another verdict.")
        if wall["opening_at_edge"]:
            yield NOTE, (f"An opening of the {name} reaches its edge: a wider wall may give "
                         "another verdict.")
        if found == "held" and wall.get("largest_passed", 0) > wall.get("largest_met", 0):
            yield NOTE, (f"The {name} is too narrow: a piece of {wall['largest_passed']:.3g} J flew"
                         f" past what is judged, and none that met it had more than "
                         f"{wall['largest_met']:.3g} J.")
        if found == "held" and wall.get("coarse", False):
            yield NOTE, (f"The {name} is too coarse to be sure of: the largest piece that met it is"
                         f" as heavy as a ball of {1e3 * wall['largest_met_diameter']:.2g} mm, and "
                         "fewer than seven of its bodies lie across that. One of smaller bodies "
                         "may fail.")
        if found == "held" and wall["rim_mass"] >= wall.get("least_spall", float("inf")):
            yield NOTE, (f"The rim of the {name}, which is not judged, has lost "
                         f"{1e3 * wall['rim_mass']:.2g} g: a wider wall may give another verdict.")
        if wall["thickness"] < FEW_LAYERS * wall["spacing"] * (1 - ROUND_OFF):
            yield NOTE, (f"The {name} is {wall['thickness'] / wall['spacing']:.2g} spacings of its "
                         f"bodies thick: fewer than {FEW_LAYERS} tell little of it.")


def converged(results):
    solver = results.get("solver", {})
    steps, failed = solver.get("solved_steps"), solver.get("steps_not_converged")
    if failed is None:
        return GOOD, ("Forces were smooth in all steps: no contact problem was solved, so there is "
                      "nothing to converge.")
    over, largest = solver.get("steps_over_tolerance", 0), solver.get("residual_max", 0)
    if relaxed := solver.get("steps_relaxed"):
        return BAD, (f"In {relaxed} of {steps} steps Coulomb's law and restitution gave contacts "
                     "no impulses that were found; the convex law of friction gave them some.")
    if failed:
        return BAD, (f"{failed} of {steps} steps did not converge: the solver ran out of "
                     f"iterations. "
                     f"The largest residual of a contact was {largest:.3g} m/s.")
    if over:
        return NOTE, (f"All {steps} steps converged as the solver measures it. In {over} of them "
                      f"the residual without its "
                      f"regularisation missed the tolerance; the largest of a contact was "
                      f"{largest:.3g} m/s.")
    return GOOD, (f"All {steps} steps converged; the largest residual of a contact was "
                  f"{largest:.3g} m/s.")


def books(results):
    conservation = results.get("conservation", {})
    if (drift := conservation.get("linear")) is not None:
        turned = conservation.get("angular", 0)
        if max(drift, turned) <= ROUND_OFF:
            yield GOOD, (f"Momentum is kept to round-off: it drifted by {drift:.1g}, angular "
                         f"momentum by {turned:.1g}.")
        elif drift <= ROUND_OFF and turned <= OF_A_TREE:
            yield NOTE, (f"Momentum is kept to round-off, angular momentum drifted by "
                         f"{turned:.2g}: "
                         "gravity by a tree keeps it to its accuracy alone, by the exact sum to "
                         "round-off.")
        else:
            yield BAD, (f"Momentum is not kept to round-off: it drifted by {drift:.2g}, angular "
                        f"momentum by {turned:.2g}.")
    elif conservation:
        yield NOTE, ("Walls or a uniform field act on the bodies, so their momentum is not kept "
                     "and no drift is told.")
    rest = conservation.get("energy_unexplained")
    if rest is None:
        return
    dissipated = conservation.get("dissipated", 0)
    other = conservation.get("energy_measure")  # unless it is what was dissipated
    if (gained := conservation.get("gained_by_restitution")) is not None:
        small = gained <= ENERGY_CLOSED * (other or dissipated)
        yield NOTE if small else BAD, (
            f"Hits gave {gained:.3g} J to clumps, beside {dissipated:.3g} J that were dissipated "
            "in all: restitution with friction may give energy where a hit is eccentric.")
    if other is None:
        measure = "what was dissipated."
    elif other > conservation.get("kinetic", other):
        measure = "what gravity gives in a step, as bodies rest."
    elif dissipated < -NEXT_TO_NOTHING * other:
        measure = "the kinetic energy, as energy was gained and not dissipated."
    else:
        measure = "the kinetic energy, as next to nothing was dissipated."
    of = f"{percent(rest)} of {measure}"
    if not dissipated and other is None:
        yield NOTE, ("Nothing was dissipated, so there is no measure for the energy that no entry "
                     "explains.")
    elif abs(rest) <= ENERGY_CLOSED:
        yield GOOD, f"The energy account closes: what no entry explains is {of}"
    elif abs(rest) <= ENERGY_OPEN:
        yield NOTE, f"The energy account nearly closes: what no entry explains is {of}"
    else:
        yield BAD, f"The energy account does not close: what no entry explains is {of}"


def percent(part):
    part = abs(100 * part)
    return f"{part:.2g} %" if part >= 0.001 else "less than 0.001 %"


def coupled(deflection):
    """What a rigid hit couples; nothing where the target is a solid."""
    if (share := deflection.get("rigid_share")) is None:
        return ""
    return (f" A rigid hit leaves {100 * share:.2g} % of the impactor's energy in the body of "
            f"{deflection['struck_mass']:.3g} kg "
            "that it meets; beta follows this share, which shock and crushing would change.")


def beta(results):
    deflection = results.get("deflection", {})
    value, plastic, elastic = (deflection.get(key)
                               for key in ("beta_along", "dv_plastic", "dv_elastic"))
    if value is None or not plastic:
        return
    bounces = "coupling" not in results
    rebound = elastic / plastic if bounces else 1
    bounce = f"1 + e = {rebound:.3g} of a bounce" if bounces else "1 of an impactor that stays"
    if (told := deflection.get("foreign_motion")) is not None:
        yield BAD, f"Beta is {value:.3g}, but {told}."
    elif (told := deflection.get("warning")) is not None:
        told = told.removeprefix("WARNING: ")
        yield NOTE, f"{told[0].upper()}{told[1:]}.{coupled(deflection)}"
    elif abs(value - rebound) <= SAME_BETA * rebound:
        yield NOTE, (f"Beta is {value:.3g}, which is only {bounce}: ejecta added "
                     f"nothing.{coupled(deflection)}")
    elif value > rebound:
        # What is coupled to the ground comes back with what was launched near the site.
        left = deflection["dv_ejecta"] + (0 if bounces else deflection["dv_rebound"])
        share = left / deflection["dv_impactor"]
        yield GOOD, (f"Beta is {value:.3g}, more than the {bounce}: ejecta carried off "
                     f"{share:.2g} of the impactor's momentum.{coupled(deflection)}")
    else:
        yield NOTE, (f"Beta is {value:.3g}, less than the {bounce}: the impactor kept part of its "
                     "momentum, or bodies left forwards.")
    if (closure := deflection.get("momentum_closure")) is not None and closure > ROUND_OFF:
        yield BAD, (f"The parts of the deflection miss its sum by {closure:.2g} of the impactor's "
                    f"momentum.")


def told_by_the_run(results):
    """Phases that were to settle and have not; lattices that lack mass; hits without a bounce."""
    for section in ("settling", "lattices", "solver"):
        if (told := results.get(section, {}).get("warning")) is not None:
            yield NOTE, f"{told[0].upper()}{told[1:]}."


def rising(results):
    read = results.get("read_out", {})
    times, dv = read.get("since_impact", []), read.get("dv", [])
    # Two that are asked for within one step are of one instant.
    before = [row for row in zip(times, dv) if row[0] < times[-1]]
    if not before or not dv[-1]:
        return None
    time, former = before[-1]
    change = (dv[-1] - former) / abs(dv[-1])
    between = f"between {readable_time(time)} and {readable_time(times[-1])} after the impact"
    if abs(change) > STILL_RISING:
        return NOTE, (f"The deflection still changed by {percent(change)} {between}: a longer run "
                      f"may give another.")
    return GOOD, f"The deflection has come to rest: it changed by {percent(change)} {between}."


def overlaps(run):
    """Rigid bodies show by overlaps that a step was long. Smooth methods refuse a step beyond their
    limit."""
    methods = {phase.get("method", "nonsmooth") for phase in run.case.get("phases", [])}
    soft = run.results.get("penalty", {}).get("overlap_max", 0)
    if soft > SOFT_OVERLAP:
        return NOTE, (f"Contacts are soft: bodies overlapped by up to {percent(soft)} of the "
                      "smaller radius. A larger stiffness would tell whether that matters.")
    if "nonsmooth" not in methods:
        return GOOD, "Steps are within the limits of the force laws: a longer one is refused."
    # Rows of the series are some of the steps; results of earlier versions have no other.
    largest = run.results.get("solver", {}).get("overlap_max")
    if largest is None:
        largest = run.series["overlap"].max(initial=0) if "overlap" in run.series else 0
    if largest > LARGE_OVERLAP:
        return NOTE, (f"Steps are near their limit: rigid bodies overlapped by up to "
                      f"{percent(largest)} of a radius. "
                      "Shorter steps would tell whether that matters.")
    return GOOD, (f"Steps are short enough: rigid bodies overlapped by at most {percent(largest)} "
                  f"of a radius.")
