#!/usr/bin/env python3
"""changed.py [--all] [--under FOLDER...]: the files that changed, a line each; on the error output against what.

Against where HEAD left the commit LUM_BASE, or else the upstream branch; where that is HEAD itself and nothing is changed, as
in a fresh clone, against the commit before it. Also what is not committed, and new files that git does not ignore. With
--all, or where no base is known, every file, and it says so. --under names folders or files; nothing is printed for others."""
import os
import pathlib
import subprocess
import sys


class Refused(Exception):
    """What was asked for cannot be done; the text says what would be right."""


def git(top, *words):
    """None where git fails."""
    r = subprocess.run(["git", "-C", str(top), *words], capture_output=True, text=True, check=False)
    return r.stdout.strip() if r.returncode == 0 else None


def names(text):
    return set(text.split("\0")) - {""} if text else set()


def is_checkout(top):
    """Not a copy within another one."""
    found = git(top, "rev-parse", "--show-toplevel")
    return found is not None and pathlib.Path(found).resolve() == top.resolve()


def listed(top, *words):
    text = git(top, *words)
    if text is None:
        raise Refused(f"git {' '.join(words)} failed: what changed is not known")
    return names(text)


def every(top):
    """All that is in the tree: as git has it, or without git all but builds."""
    if is_checkout(top):
        return listed(top, "ls-files", "-z") | uncommitted(top)
    return {str(f.relative_to(top)) for f in top.rglob("*")
            if f.is_file() and not f.relative_to(top).parts[0].startswith(("build", ".git", "out"))}


def uncommitted(top):
    return listed(top, "diff", "-z", "--name-only", "HEAD") | listed(top, "ls-files", "-z", "--others", "--exclude-standard")


def base_of(top):
    """(commit, why it), or (None, why none)."""
    wanted = os.environ.get("LUM_BASE")
    if not is_checkout(top):
        return None, "this is no checkout of git"
    if wanted:
        if git(top, "rev-parse", "--verify", "--quiet", f"{wanted}^{{commit}}") is None:
            raise Refused(f"LUM_BASE={wanted} is no commit of this repository: name one, or unset it")
        commit = git(top, "merge-base", "HEAD", wanted)
        return commit, "LUM_BASE" if commit else f"LUM_BASE={wanted} has no commit in common with HEAD here"
    for upstream in "@{upstream}", "origin/HEAD":
        commit = git(top, "merge-base", "HEAD", upstream)
        if commit is not None:
            name = git(top, "rev-parse", "--abbrev-ref", upstream)
            if commit == git(top, "rev-parse", "HEAD") and not uncommitted(top):
                before = git(top, "rev-parse", "--verify", "--quiet", "HEAD^")
                return before, f"the commit before {name}, which HEAD is" if before else "HEAD has no commit before it"
            return commit, name
    return None, "no upstream branch and no LUM_BASE"


def changed(top, everything=False):
    """(files or None for all, a sentence)."""
    if everything:
        return None, "all files"
    commit, why = base_of(top)
    if commit is None:
        return None, f"all files, because the base is not known: {why}"
    files = listed(top, "diff", "-z", "--name-only", commit, "HEAD") | uncommitted(top)
    return files, f"what changed since {commit[:10]} ({why})"


def is_under(name, folders):
    return not folders or any(name == f or name.startswith(f.rstrip("/") + "/") for f in folders)


def main():
    top = pathlib.Path(__file__).resolve().parents[1]
    words = sys.argv[1:]
    folders = words[words.index("--under") + 1:] if "--under" in words else []
    try:
        files, sentence = changed(top, "--all" in words)
        if files is None:
            files = every(top)
        else:
            sentence = f"not run: all but {sentence}"
    except Refused as refusal:
        sys.exit(f"changed.py: {refusal}")
    there = sorted(f for f in files if is_under(f, folders) and (top / f).is_file())
    print(f"{sentence}: {len(there)} files", file=sys.stderr)
    print("".join(f"{f}\n" for f in there), end="")


if __name__ == "__main__":
    main()
