"""The site of pages, demos and reference is built without a warning, and no link leads nowhere or elsewhere."""

import re
import subprocess
from pathlib import Path
from urllib.parse import unquote

import pytest

ROOT = Path(__file__).parents[1]
CREDITS = {"https://github.com/pradyunsg/furo", "https://pradyunsg.me", "https://www.sphinx-doc.org/"}


@pytest.mark.slow
def test_site():
    done = subprocess.run([ROOT / "demos" / "pages" / "make", "--run", "bratu"], capture_output=True, text=True)
    if "No matching distribution" in done.stderr:
        pytest.skip("no Sphinx within reach")
    assert done.returncode == 0 and not done.stderr, done.stderr
    site = ROOT / "site"
    pages = [page for page in site.rglob("*.html") if not page.relative_to(site).parts[0].startswith(".")]
    assert len(pages) > 100
    nowhere, elsewhere = set(), set()
    for page in pages:
        text = page.read_text()
        for link in re.findall(r'(?:href|src)="([^"#?]+)', text):
            if re.match(r"[a-z]+:", link):
                elsewhere.add(link)
            elif not (page.parent / unquote(link)).exists():
                nowhere.add((page.name, link))
        prose = re.sub(r"<(pre|code|script)\b.*?</\1>", "", text, flags=re.DOTALL)
        assert "$" not in prose, f"{page}: a formula is not one"
        assert not re.search(r'<(?:script|link|img)[^>]*(?:src|href)="https?:', text), page
    assert "limit point (maximum) at 3.51383" in (site / "bratu.html").read_text()
    assert not nowhere and {link for link in elsewhere if not link.startswith("data:")} <= CREDITS
