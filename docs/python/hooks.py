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
