# SPDX-License-Identifier: Apache-2.0
"""Every link, picture and anchor of the built site leads to something in the site: links.py HTML. Ends with 77 where the
site is not built."""
from __future__ import annotations

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """What a page links to, and the anchors that it has."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name in ("id", "name") and value:
                self.anchors.add(value)
            if name in ("href", "src") and value:
                self.links.append(value)


def main(html: Path) -> int:
    if not (html / "index.html").is_file():
        print(f"skipped: {html} has no site; ./dev docs builds it")
        return 77
    pages = {path: Page(path.read_text()) for path in html.resolve().rglob("*.html")}
    faults, checked = [], 0
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                # Without a network the site must have all that it shows; a link for people may lead out.
                if parts.scheme not in ("https", "http", "mailto", "data"):
                    faults.append(f"{path}: {link}")
                continue
            checked += 1
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.is_file():
                faults.append(f"{path}: there is no {link}")
            elif parts.fragment and unquote(parts.fragment) not in pages[target].anchors if target in pages else False:
                faults.append(f"{path}: {link} has no such anchor")
    if faults:
        print("\n".join(sorted(set(faults))[:100]))
        return 1
    # A site of a few pages, or without links between them, is not the site.
    if len(pages) < 100 or checked < 10 * len(pages):
        print(f"only {checked} links in {len(pages)} pages")
        return 1
    print(f"{checked} links in {len(pages)} pages lead somewhere")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
