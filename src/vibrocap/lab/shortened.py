"""Scripts without what only a reader of their source needs: comments, and spaces that part nothing."""

import re

# What is left as it is: texts, and what is matched by a slash after a sign that begins a value.
TEXT = re.compile(
    r""""(?:[^"\\\n]|\\.)*"|'(?:[^'\\\n]|\\.)*'|(?<=[(,=:!&|?;{}\[])\s*/(?![/*])(?:[^/\\\n\[]|\\.|\[(?:[^\]\\\n]|\\.)*\])+/[a-z]*"""
)
COMMENT = re.compile(r"\s*//[^\n]*|/\*.*?\*/", re.DOTALL)
WORDS = re.compile(r"[\w$]+")
SPACES = re.compile(r"\s+")
WORD = re.compile(r"[\w$]")
GOES_ON = set("{};,(=?:&|[")  # signs after which the end of a line ends no statement


def shortened(script: str) -> str:
    """A script that does the same, of one whose statements all end with a semicolon or a brace."""
    return _until(script, 0, "")[0].strip()


def _until(script: str, at: int, end: str) -> tuple[str, int]:
    """(the script from a place to a closing brace or to its end, the place behind that)."""
    out: list[str] = []
    depth = 0
    while at < len(script):
        letter = script[at]
        if letter == "`":
            text, at = _template(script, at)
            out.append(text)
        elif match := TEXT.match(script, at) or WORDS.match(script, at):
            out.append(match[0].lstrip())
            at = match.end()
        elif match := COMMENT.match(script, at):
            at = match.end()
        elif match := SPACES.match(script, at):
            at = match.end()
            before = out[-1][-1] if out else "{"
            after = script[at] if at < len(script) else "}"
            if "\n" in match[0] and before not in GOES_ON and after not in "})]?:.,&|":
                out.append("\n")
            elif (WORD.match(before) and WORD.match(after)) or (before in "+-" and after in "+-"):
                out.append(" ")
        else:
            depth += {"{": 1, "}": -1}.get(letter, 0)
            if depth < 0 and end:
                return "".join(out), at + 1
            out.append(letter)
            at += 1
    return "".join(out), at


def _template(script: str, at: int) -> tuple[str, int]:
    """(a text between backticks, the place behind it): the expressions in it are shortened, the text is not."""
    out, at = ["`"], at + 1
    while script[at] != "`":
        if script.startswith("${", at):
            inner, at = _until(script, at + 2, "}")
            out.append(f"${{{inner}}}")
            continue
        width = 2 if script[at] == "\\" else 1
        out.append(script[at : at + width])
        at += width
    return "".join([*out, "`"]), at + 1
