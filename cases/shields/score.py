"""Scores Spall and five equations on the same shots: table and plot of README.md, from results.csv,
or of former.md, from those of former laws.

    python3 cases/shields/score.py [--across 18] [--wall-across 6] [--seed 1] ...
    python3 cases/shields/score.py --until 41c754d     by the law until this commit

SPDX-License-Identifier: BSD-3-Clause
"""
import argparse
import sys
from math import comb, sqrt
from pathlib import Path

from equations import EQUATIONS, SWAPPED, is_right, mended, read_shots
from largest_piece import largest_piece
from run import (FINE, MOST_COMING, RESULTS, RULE, SECOND, ask_for_setting, beside, chosen,
                 ended_early, is_of, known)

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent.parent / "bench"))
from readme import replace_section  # noqa: E402

FAILED = {"held": False, "detached spall": True, "perforated": True}
MOST_UNEXPLAINED = 0.01  # of the impact's energy: beyond that a run tells nothing
# Of the published ones on all shots of the table and on the cheap ones (JSC is its equal there).
BEST = "modified JSC"
NEAR = (0.8, 1.25)  # ball diameters over the critical one
SECOND_LOOK = "Spall, at second look"  # again where a wall held
# It was chosen when the shots of this file were known, and those by these commits, and is tested
# on others.
KNOWN_FROM = RESULTS.with_stem(RESULTS.stem + "_until_f5f5c5b")
KNOWN_BY = {"0c79e7a", "54ff7fc", "73b316e", "87152bd", "bbf13a9", "ffdeaad"}
BY_FORMULA = "Spall, and Cour-Palais for its largest piece"
CHEAP, BESIDE, BOTH = (chosen,), (beside,), (chosen, beside)  # rules
# Reports of one laboratory: a shot of the same number in both is one shot, if what they tell of it
# is the same but for rounding.
REPORTS = {"AFML-TR-67-324", "AFML-TR-68-257"}
ROUNDING = 0.03


def mcnemar(first, second):
    """The exact two-sided test of two callers of the same shots: the odds of so uneven a split of
    those that only one of them calls right, if both were equally good."""
    only_first = sum(a and not b for a, b in zip(first, second))
    only_second = sum(b and not a for a, b in zip(first, second))
    n, least = only_first + only_second, min(only_first, only_second)
    return only_first, only_second, min(1.0, 2 * sum(comb(n, k) for k in range(least + 1)) / 2**n)


def by_shields(shields, first, second):
    """McNemar's test where shots at one shield may be right or wrong together: the odds of so
    large a difference if each shield's were as likely to have the other sign, exactly. Where no
    shield is shot at twice it is McNemar's own."""
    differences = {}
    for shield, a, b in zip(shields, first, second):
        differences[shield] = differences.get(shield, 0) + int(a) - int(b)
    ways = {0: 1}  # sum -> in how many choices of signs
    for d in filter(None, differences.values()):
        turned = {}
        for total, count in ways.items():
            for sign in (d, -d):
                turned[total + sign] = turned.get(total + sign, 0) + count
        ways = turned
    found = abs(sum(differences.values()))
    return sum(n for total, n in ways.items() if abs(total) >= found) / sum(ways.values())


def holm(odds):
    """Of some tests at once: each p-value as if the others had not been made (Holm 1979)."""
    adjusted, largest = [0.0] * len(odds), 0.0
    for done, k in enumerate(sorted(range(len(odds)), key=odds.__getitem__)):
        largest = max(largest, min(1.0, (len(odds) - done) * odds[k]))
        adjusted[k] = largest
    return adjusted


def share(calls):
    """Share called right, in per cent, with Wilson's interval of one standard error."""
    if not calls:
        return "–"
    n, p = len(calls), sum(calls) / len(calls)
    centre = (p + 1 / (2 * n)) / (1 + 1 / n)
    half = sqrt(p * (1 - p) / n + 1 / (4 * n**2)) / (1 + 1 / n)
    low, high = 100 * (centre - half), 100 * (centre + half)
    return f"{100 * p:.0f} ({low:.0f}–{high:.0f}) %"


def has_verdict(line):
    """Whether a run has one that counts."""
    return (line["verdict"] in FAILED and float(line["energy_unexplained"]) <= MOST_UNEXPLAINED
            and not ended_early(line))


def counted(shots, options):
    """(shot, line of results.csv) of what was run by `options.rules` and has a verdict; how many
    have none, and how many the rules have."""
    by_row = {shot.row: shot for rule in options.rules for shot in rule(shots)}
    lines = [line for line in known(options.results) if int(line["row"]) in by_row
             and is_of(line, options)]
    good = [line for line in lines if has_verdict(line)]
    return [(by_row[int(line["row"])], line) for line in good], len(lines) - len(good), len(by_row)


def is_copy(one, other):
    """Whether two rows of the table are one shot."""
    numbers = ("diameter", "speed", "bumper", "standoff", "wall")
    return (one.name == other.name and {one.source, other.source} == REPORTS
            and one.perforated == other.perforated
            and all(abs(getattr(one, key) - getattr(other, key)) <= ROUNDING * getattr(one, key)
                    for key in numbers))


def each_once(some):
    """Without the rows that are copies of one run before."""
    kept = []
    for shot, line in some:
        if not any(is_copy(shot, before) for before, _ in kept):
            kept.append((shot, line))
    return kept


def coarse_calls(some, options):
    """{name: calls} of the rule's own setting, where that is another and has called all of them."""
    rule = argparse.Namespace(**vars(options) | vars(RULE) | {"seed": options.seed})
    if (options.across, options.wall_across) == (rule.across, rule.wall_across):
        return {}
    verdicts = {shot.row: line["verdict"] for shot, line in counted(read_shots(), rule)[0]}
    if not all(shot.row in verdicts for shot, _ in some):
        return {}
    return {f"Spall, {RULE.across:g} across": [FAILED[verdicts[shot.row]] == shot.perforated
                                        for shot, _ in some]}


def of_other_seeds(some, options):
    """In words: how many of these shots, run with crystals that are turned otherwise, Spall calls
    otherwise, and the standard error that this alone gives the share that it calls right."""
    fails = {shot.row: FAILED[line["verdict"]] for shot, line in some}
    seeds = {int(line["seed"]) for line in known(options.results)} - {options.seed}
    again = [(shot.row, FAILED[line["verdict"]], line["commit"]) for seed in sorted(seeds)
             for shot, line in counted(read_shots(), argparse.Namespace(
                 **vars(options) | {"seed": seed}))[0]
             if shot.row in fails]
    if not again:
        return ""
    changed = [row for row, failed, _ in again if failed != fails[row]]
    # Of two draws of a call that is made with odds p, 2 p (1 - p) differ.
    error = sqrt(len(changed) / len(again) / 2 / len(some))
    rows = f" (rows {', '.join(map(str, changed))})" if changed else ""
    commits = ", ".join(sorted({commit for _, _, commit in again}))
    return (f"{len(again)} runs of these shots with crystals turned otherwise (other seeds), by "
            f"{commits}: {len(changed)} are called otherwise{rows}. That alone would be a standard "
            f"error of {100 * error:.0f} % of the share that Spall calls right.")


def has_piece(line):
    """Whether a run told the largest piece that met its wall: former runs did not."""
    return bool(line["largest_met_j"])


def at_second_look(some, options):
    """{row: whether the wall fails in either run}, of those shots whose wall failed or was looked
    at again, with a verdict that counts."""
    fails = {line["row"]: True for _, line in some if FAILED[line["verdict"]]}
    if options.results != RESULTS:
        return fails
    needs = {line["row"]: f"{largest_piece(shot, float(line['largest_met_j'])).needs:.4g}"
             for shot, line in some if has_piece(line)}
    for line in known(SECOND):
        # Of another run of the shot it tells nothing.
        belongs = line["row"] in needs and line["needs_mm"] in ("", needs[line["row"]])
        explained = float(line["unexplained_of_dissipated"] or 0) <= MOST_UNEXPLAINED
        if is_of(line, options) and belongs and explained and line["verdict"] in FAILED:
            fails.setdefault(line["row"], FAILED[line["verdict"]])
    return fails


def by_formula(some):
    """{row: whether the wall fails, or is thinner than Cour-Palais's formula asks for}, of those
    shots of which the largest piece is told, or whose wall failed without."""
    return {line["row"]: FAILED[line["verdict"]]
            or largest_piece(shot, float(line["largest_met_j"])).needs > 10 * shot.wall
            for shot, line in some if has_piece(line) or FAILED[line["verdict"]]}


def second_calls(some, options):
    """{name: calls} of the two that look again where a wall held; of each that can call all."""
    again = {SECOND_LOOK: at_second_look(some, options), BY_FORMULA: by_formula(some)}
    return {name: [fails[line["row"]] == shot.perforated for shot, line in some]
            for name, fails in again.items() if len(fails) == len(some)}


def calls_of(some, options):
    """{name: whether it calls each shot right}, of Spall, at both settings and at second look, and
    of the others."""
    ours = {"Spall": [FAILED[line["verdict"]] == shot.perforated for shot, line in some],
            **coarse_calls(some, options), **second_calls(some, options)}
    others = {name: [is_right(shot, name) for shot, _ in some] for name in EQUATIONS}
    others["every wall held"] = [not shot.perforated for shot, _ in some]
    return ours, others


def tests_of(some, ours, others):
    """{name: (shots that this caller alone calls right, that it alone calls wrong, McNemar's odds,
    those by shields)}"""
    shields = [(shot.metals[1:], shot.bumper, shot.standoff, shot.wall) for shot, _ in some]
    return {name: (*mcnemar(ours, calls), by_shields(shields, ours, calls))
            for name, calls in others.items()}


def in_short(test):
    """One of `tests_of`, with the larger of its two odds."""
    right, wrong, *odds = test
    return f"{right} : {wrong}, p = {max(odds):.2g}"


def of_five_tests(tests):
    """{equation: the larger of its two odds, by Holm's method}"""
    return dict(zip(EQUATIONS, holm([max(tests[name][2:]) for name in EQUATIONS])))


def with_mended(told):
    """The same with mended labels. `told`: with those of the table."""
    return [(shot, line) for shot, (_, line) in zip(mended([shot for shot, _ in told]), told)]


def by_labels(told, options):
    """Table of what the labels of SWAPPED decide, and rows that are copies. `told`: with the labels
    of the table."""
    by_mended = with_mended(told)
    sets = {f"{SWAPPED} mended": by_mended, "each shot once": each_once(by_mended),
            "as the table has it": told,
            "without this report": [(shot, line) for shot, line in told if shot.source != SWAPPED]}
    text = [f"| called right | {' | '.join(sets)} |", f"|---|{'--:|' * len(sets)}",
            f"| shots | {' | '.join(str(len(some)) for some in sets.values())} |"]
    rows = {caller: [] for callers in calls_of(told, options) for caller in callers}
    for some in sets.values():
        ours, others = calls_of(some, options)
        tests = tests_of(some, ours["Spall"], others)
        for caller, cells in rows.items():
            calls = (ours | others)[caller]
            cells.append(f"{sum(calls)}, {share(calls)}")
            if caller in tests:
                cells[-1] += f"; {in_short(tests[caller])}"
    text += [f"| {caller} | {' | '.join(cells)} |" for caller, cells in rows.items()]
    return "\n".join(text)


def table(some, without, planned, options):
    if not some:
        return f"None of {planned} shots has been run."
    ours, others = calls_of(some, options)
    ratio = [shot.diameter / EQUATIONS[BEST](shot) for shot, _ in some]
    parts = {"all": [True] * len(some), "below 5 km/s": [shot.speed < 5 for shot, _ in some],
             "5–7 km/s": [5 <= shot.speed < 7 for shot, _ in some],
             "from 7 km/s": [shot.speed >= 7 for shot, _ in some],
             "d/d_c < 0.8": [r < NEAR[0] for r in ratio],
             "0.8–1.25": [NEAR[0] <= r <= NEAR[1] for r in ratio],
             "> 1.25": [r > NEAR[1] for r in ratio]}

    def of(calls, part):
        return [call for call, inside in zip(calls, parts[part]) if inside]

    text = [f"{len(some)} of {planned} shots, {options.across:g} across, the wall "
            f"{options.wall_across:g}, seed {options.seed}; "
            f"{without} more have no verdict: failed, took too long, energy is wrong by more than "
            "a hundredth of the impact's, or the wall held what came until then.", "",
            f"| called right | {' | '.join(parts)} | McNemar beside Spall |",
            f"|---|{'--:|' * len(parts)}---|",
            f"| shots | {' | '.join(str(sum(inside)) for inside in parts.values())} | |"]
    tests = tests_of(some, ours["Spall"], others)
    adjusted = of_five_tests(tests)
    for name, calls in (ours | others).items():
        beside = ""
        if name in tests:
            right, wrong, odds, by_shield = tests[name]
            beside = (f"{right} that Spall alone calls right, {wrong} that it alone calls wrong, "
                      f"p = {odds:.2g}, by shields {by_shield:.2g}")
        if name in adjusted:
            beside += f", of five tests {adjusted[name]:.2g}"
        text.append(f"| {name} | {' | '.join(share(of(calls, part)) for part in parts)} "
                    f"| {beside} |")

    def count(verdict, perforated):
        return sum(line["verdict"] == verdict and shot.perforated == perforated
                   for shot, line in some)

    text += ["", "In brackets: Wilson's interval of one standard error, of independent shots. "
             f"d/d_c is the ball over what {BEST} calls critical.", "",
             "| verdict of Spall | wall was perforated | wall held |", "|---|--:|--:|"]
    text += [f"| {verdict} | {count(verdict, True)} | {count(verdict, False)} |"
             for verdict in FAILED]
    commits = sorted({line["commit"] for _, line in some})
    late = sum(float(line["still_coming"]) > MOST_COMING for _, line in some)
    edge = sum(line["opening_at_edge"] == "True" for _, line in some)
    narrow = ""
    if all(has_piece(line) for _, line in some):
        past = sum(float(line["largest_passed_j"]) > float(line["largest_met_j"])
                   for _, line in some)
        narrow = f"in {past} a larger piece flew past the wall than any that met it, "
    if some:
        worst = max(float(line["energy_unexplained"]) for _, line in some)
        hours = sum(float(line["seconds"]) for _, line in some) / 3600
        text += ["", f"In {late} of these runs more than a hundredth of the energy had not met the "
                 f"wall in the end, {narrow}in {edge} an opening reached the wall's rim. Energy "
                 f"that no entry explains: at most {100 * worst:.2g} % of the impact's. "
                 f"{hours:.1f} hours, one rank each. Commits: {', '.join(commits)}.", "",
                 of_other_seeds(some, options)]
    return "\n".join(text).rstrip("\n")


def of_unknown(unknown, when, tested, options):
    """Table of the shots that were not known `when`, beside `tested`. `unknown`: with the labels of
    the table."""
    if not unknown:
        return ""
    some = with_mended(unknown)
    ours, others = calls_of(some, options)
    by_table = {name: calls for callers in calls_of(unknown, options)
                for name, calls in callers.items()}
    tested = tested if tested in ours else "Spall"
    tests = tests_of(some, ours[tested], others)
    adjusted = of_five_tests(tests)
    looked = len(at_second_look(some, options))
    text = ["", "", f"{len(some)} of these shots were not known {when}. {looked} of their walls "
            "failed, or were looked at again.", "",
            f"| these {len(some)} | called right | McNemar beside {tested} | as the table has it |",
            "|---|--:|---|--:|"]
    for name, calls in (ours | others).items():
        beside = ""
        if name in tests:
            beside = in_short(tests[name])
        if name in adjusted:
            beside += f", of five tests {adjusted[name]:.2g}"
        text.append(f"| {name} | {sum(calls)}, {share(calls)} | {beside} | {sum(by_table[name])} |")
    return "\n".join(text)


def afterwards(told, options):
    """Tables of the shots that were not known when the runs of this law began, and when the second
    look was chosen. `told`: with the labels of the table."""
    known_then = {line["row"] for line in known(KNOWN_FROM)}
    unknown = [(shot, line) for shot, line in told if line["row"] not in known_then]
    text = ""
    if len(unknown) < len(told):
        text += of_unknown(unknown, "when runs by this law began", "Spall", options)
    if options.rules == BOTH:
        later = [(shot, line) for shot, line in unknown if line["commit"] not in KNOWN_BY]
        judged = at_second_look(later, options)
        without = {line["row"] for line in known(SECOND) if is_of(line, options)} - set(judged)
        out = [line["row"] for _, line in later if line["row"] in without]
        good = [(shot, line) for shot, line in later if line["row"] not in without]
        text += of_unknown(good, "when the second look was chosen", SECOND_LOOK, options)
        if out:
            text += f"\n\nWithout a verdict at second look, and left out: row {', '.join(out)}."
    return text


def draw(some, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import FixedLocator, NullLocator
    figure, axes = plt.subplots(figsize=(7, 4.2))
    for perforated, fill in ((True, True), (False, False)):
        for right, color in ((True, "#2f6db3"), (False, "#c8452f")):
            at = [(shot.speed, shot.diameter / EQUATIONS[BEST](shot)) for shot, line in some
                  if shot.perforated == perforated
                  and (FAILED[line["verdict"]] == perforated) == right]
            axes.scatter([x for x, _ in at], [y for _, y in at], edgecolors=color,
                         facecolors=color if fill else "none",
                         label=f"{'perforated' if perforated else 'held'}, "
                               f"Spall {'right' if right else 'wrong'}")
    axes.axhline(1, color="0.6", linewidth=0.8)
    axes.set(xlabel="speed (km/s)", ylabel=f"ball over critical ball of {BEST}", yscale="log")
    ticks = [0.4, 0.5, 0.6, 0.7, 0.8, 1, 1.2, 1.4, 1.7, 2, 3, 4, 6]
    axes.yaxis.set_major_locator(FixedLocator(ticks))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter("{x:g}")
    axes.legend(fontsize=8)
    figure.savefig(path, dpi=110, bbox_inches="tight")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    ask_for_setting(parser)
    parser.add_argument("--until", default="", metavar="COMMIT",
                        help="score the runs of results_until_COMMIT.csv, by the law until then")
    options = parser.parse_args()
    ending = f"_until_{options.until}" if options.until else ""
    options.results = RESULTS.with_stem(RESULTS.stem + ending)
    page = HERE / ("former.md" if options.until else "README.md")
    name = f"score_{options.across:g}_{options.wall_across:g}{ending}"
    today = options.results == RESULTS and is_of(vars(FINE), options)
    sections = {name: CHEAP} | ({"score_beside": BESIDE, "score_both": BOTH} if today else {})
    runs_by = {}
    for section, options.rules in sections.items():
        told = counted(read_shots(), options)[0]
        some, without, planned = counted(mended(read_shots()), options)
        runs_by[options.rules] = len(some)
        if options.rules == BOTH and runs_by[BESIDE] == 0:
            text = "As for the cheap ones, until some of the second rule's have been run."
        else:
            text = table(some, without, planned, options)
            if some:
                text += "\n\n" + by_labels(told, options)
        if today:
            text += afterwards(told, options)
        print(f"{section}\n{text}")
        replace_section(page, section, text)
        if options.rules == CHEAP:
            draw(some, HERE / f"{name}.png")


if __name__ == "__main__":
    main()
