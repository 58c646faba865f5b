"""pages PAGE [SECTION]: runs the blocks of Python of a page of documents, or of one of its sections, in their order and in one
namespace, in the working directory. A block of text behind one is what it prints. Comments right before a block, a line each:
  <!-- needs: NAME, ... -->  modules without which it and what follows of the page is left out; status 77 says so
  <!-- given: CODE -->       what a reader is assumed to have done before
  <!-- shown: WHY -->        it is only compiled
The function use() of the pages does nothing."""
import contextlib
import doctest
import importlib.util
import io
import pathlib
import re
import sys
import traceback
import typing

BLOCK = re.compile(r"(?P<marks>(?:^<!-- \w+: .*? -->\n)*)\n?^```python\n(?P<code>.*?)^```\n(?:\n```text\n(?P<text>.*?)^```\n)?", re.M | re.S)
MARK = re.compile(r"^<!-- (needs|given|shown): (.*?) -->$", re.M)


class Block(typing.NamedTuple):
    line: int  # of its first line of code
    code: str
    needs: list
    text: typing.Optional[str]  # what it prints
    given: str
    is_shown: bool  # and not run
    section: str  # the heading of the second level that it is under


def blocks(page):
    """The blocks of a page, in their order."""
    content = pathlib.Path(page).read_text(encoding="utf-8")
    for found in BLOCK.finditer(content):
        marks = dict(MARK.findall(found["marks"]))
        needs = [name.strip() for name in marks.get("needs", "").split(",") if name.strip()]
        yield Block(content.count("\n", 0, found.start("code")) + 1, found["code"], needs, found["text"],
                    marks.get("given", ""), "shown" in marks, re.findall(r"^## (.*)$", "## \n" + content[:found.start()], re.M)[-1])


def is_missing(name):
    try:
        return importlib.util.find_spec(name) is None
    except ModuleNotFoundError:
        return True


def run(block, page, names):
    """Run one; raises AssertionError if it prints something else than told."""
    printed = io.StringIO()
    code = compile("\n" * (block.line - 1) + block.code, str(page), "exec")
    if block.is_shown:
        return
    with contextlib.redirect_stdout(printed):
        exec(block.given, names)
        exec(code, names)
    checker = doctest.OutputChecker()
    if block.text is not None and not checker.check_output(block.text, printed.getvalue(), doctest.ELLIPSIS):
        raise AssertionError(f"it prints\n{printed.getvalue()}and not\n{block.text}")


def main(page, section=None):
    names = {"__name__": "__main__", "use": lambda *_: None}
    for block in blocks(page):
        if section not in (None, block.section):
            continue
        missing = [name for name in block.needs if is_missing(name)]
        if missing:
            print(f"{page}:{block.line}: left out from here on: there is no {', '.join(missing)}")
            return 77
        try:
            run(block, page, names)
        except BaseException:
            traceback.print_exc()
            print(f"{page}:{block.line}: the block that begins here fails", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
