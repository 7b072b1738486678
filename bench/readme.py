"""Puts text into a README, between <!-- name --> and <!-- end of name -->.

SPDX-License-Identifier: BSD-3-Clause
"""


def replace_section(path, name, text):
    whole = path.read_text()
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    before, rest = whole.split(begin)
    path.write_text(before + begin + "\n" + text + "\n" + end + rest.split(end)[1])
