#!/usr/bin/env python3
# Writes the man page and the completions of bash and zsh from what `spall --help` says.
# SPDX-License-Identifier: BSD-3-Clause
"""usage: write_help.py SPALL VERSION FOLDER    writes spall.1, spall.bash and _spall into FOLDER"""
import re
import subprocess
import sys
from pathlib import Path


class Help:
    """Of the program, or of one of its subcommands; rows are pairs of a name and its meaning."""

    def __init__(self, spall, *words):
        text = subprocess.run([spall, *words, "--help"], check=True, capture_output=True,
                              text=True).stdout
        text = re.sub(r"^usage:.*\n(?: {8,}.*\n)*", "", text, flags=re.M | re.I)
        headings = r"^(Positionals|Options|Subcommands|positional arguments|options):\n"
        self.introduction, *parts = re.split(headings, text, flags=re.M)
        rows = dict(zip((name.lower().split()[0] for name in parts[::2]), parts[1::2]))
        self.conclusion = parts[-1].partition("\n\n")[2]
        self.arguments = self.rows(rows.get("positionals") or rows.get("positional", ""))
        self.options = self.rows(rows["options"])
        self.subcommands = self.rows(rows.get("subcommands", ""))

    @staticmethod
    def rows(text):
        found = re.findall(r"^  (\S.*?)(?:  +|\n {8,})(.*(?:\n {8,}.*)*)",
                           text.partition("\n\n")[0], re.M)
        return [(name.removesuffix(" REQUIRED").replace(",--", ", --"), " ".join(meaning.split()))
                for name, meaning in found]

    def long_options(self):
        return [word for name, _ in self.options for word in re.findall(r"--[\w-]+", name)]

    def choices(self):
        """--method -> accelerated, apgd, ..."""
        return {found[1]: found[2].split(" | ") for name, _ in self.options
                if (found := re.fullmatch(r"(--[\w-]+) ENUM:(.*)", name))}


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("`", "\\`")
    return re.sub(r"^(?=[.'])", r"\\&", text, flags=re.M)


def man_page(whole, parts, version):
    def listed(rows):
        return [f".TP\n.B {roff(name)}\n{roff(meaning)}" for name, meaning in rows]

    def verbatim(text):
        return [".nf", roff(text.strip("\n")), ".fi"]

    title, _, rest = whole.introduction.partition("\n")
    lines = [f'.TH SPALL 1 "" "spall {version}" "User Commands"', ".SH NAME",
             roff(title.rstrip(".")).replace("Spall ", "spall \\- ", 1),
             ".SH SYNOPSIS", ".B spall", "SUBCOMMAND [OPTIONS]", ".SH DESCRIPTION", *verbatim(rest),
             ".SH OPTIONS", *listed(whole.options), ".SH SUBCOMMANDS"]
    for (name, meaning), part in zip(whole.subcommands, parts):
        arguments = " ".join(argument.split()[0].upper() for argument, _ in part.arguments)
        lines += [f'.SS "spall {name} {arguments}"', roff(meaning[0].upper() + meaning[1:] + ".")]
        lines += listed([*part.arguments, *((n, m) for n, m in part.options if "--help" not in n)])
        if name in ("sweep", "limit"):  # they explain themselves at length
            lines += [".PP", *verbatim(part.introduction.partition("\n\n")[2])]
    return "\n".join([*lines, ".SH NOTES", *verbatim(whole.conclusion)]) + "\n"


def completions(whole, parts):
    """For bash and for zsh: the same words."""
    names = [name for name, _ in whole.subcommands]
    cases = "".join(f"    {name}) options='{' '.join(part.long_options())}' ;;\n"
                    for name, part in zip(names, parts))
    values = "".join(f"    {option}) values='{' '.join(choices)}' ;;\n"
                     for part in parts for option, choices in part.choices().items())
    table = f"""  local commands='{' '.join([*names, *whole.long_options()])}' options='' values=''
  case $command in
{cases}  esac
  case $before in
{values}  esac
"""
    bash = f"""# Completion of spall for bash. SPDX-License-Identifier: BSD-3-Clause
_spall() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
  local command=${{COMP_WORDS[1]}} words=''
{table}  if [ "$COMP_CWORD" = 1 ]; then words=$commands; elif [ "$values" ]; then words=$values; fi
  [ "$COMP_CWORD" != 1 ] && [[ $current == -* ]] && words=$options
  COMPREPLY=($(compgen -W "$words" -- "$current"))
}}
complete -o default -F _spall spall
"""
    zsh = f"""#compdef spall
# Completion of spall for zsh. SPDX-License-Identifier: BSD-3-Clause
_spall() {{
  local before=$words[CURRENT-1] command=$words[2]
{table}  if (( CURRENT == 2 )); then compadd -- ${{=commands}}
  elif [[ $PREFIX == -* ]]; then compadd -- ${{=options}}
  elif [[ -n $values ]]; then compadd -- ${{=values}}
  else _files; fi
}}
_spall "$@"
"""
    return bash, zsh


def main(spall, version, folder):
    whole = Help(spall)
    parts = [Help(spall, name) for name, _ in whole.subcommands]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "spall.1").write_text(man_page(whole, parts, version))
    bash, zsh = completions(whole, parts)
    (folder / "spall.bash").write_text(bash)
    (folder / "_spall").write_text(zsh)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]))
