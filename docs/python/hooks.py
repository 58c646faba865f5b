"""For mkdocs: a link to a file that is not part of the site, such as a source, becomes its text."""
import posixpath
import re

LINK = re.compile(r"(?<!!)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s#]+)(#[^)\s]*)?\)")
BLOCK = re.compile(r"^```.*?^```", re.M | re.S)


def on_page_markdown(markdown, page, config, files):
    """Pages refer to the repository, which has more files than the site."""
    folder = posixpath.dirname(page.file.src_uri)

    def inside(match):
        target = match[2]
        if re.match(r"[a-z]+:", target) or files.get_file_from_path(posixpath.normpath(posixpath.join(folder, target))):
            return match[0]
        return match[1]

    kept = []

    def keep(match):
        kept.append(match[0])
        return f"\0{len(kept) - 1}\0"

    text = LINK.sub(inside, BLOCK.sub(keep, markdown))
    return re.sub(r"\0(\d+)\0", lambda match: kept[int(match[1])], text)


PLAIN = re.compile(r'(?:<div class="highlight">)?<pre><span></span><code>([^<]*)</code></pre>(?:</div>)?')
ROW = re.compile(r"(\S.*?)  +(.*(?:\n +\S.*)*)")


def as_table(match):
    """A block of docstrings that is a table, names and what is said of them, as one: its lines are as wide as there is room."""
    text = match[1].rstrip("\n")
    rows = list(ROW.finditer(text))
    if "\n".join(row[0] for row in rows) != text:
        return match[0]
    cells = "".join(f"<tr><td><code>{row[1]}</code></td><td>{' '.join(row[2].split())}</td></tr>" for row in rows)
    return f"<table><tbody>{cells}</tbody></table>"


def on_page_content(html, page, config, files):
    """Docstrings have their tables as a terminal shows them."""
    return PLAIN.sub(as_table, html) if page.file.src_uri == "python/reference.md" else html
