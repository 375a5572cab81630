# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The product holds no definition that only tests use."""

from pathlib import Path

from support.references import unused

ROOT = Path(__file__).resolve().parents[2]
SOURCES = [
    file
    for file in sorted(ROOT.glob("pmwvc_*/pmwvc_*/**/*"))
    if file.suffix in (".py", ".html") and "egg-info" not in str(file)
]
OTHERS = [
    *ROOT.glob("pmwvc_*/setup.py"),
    ROOT / "pmwvc_bringup" / "pmwvc.py",
    *ROOT.glob("pmwvc_*/launch/*.py"),
    *ROOT.glob("tools/**/*.py"),
]
ALLOWED = {}


def names(*arguments):
    return {definition.where for definition in unused(*arguments)}


def test_every_definition_of_the_product_is_used_by_the_product():
    assert len(SOURCES) > 200
    assert names(ROOT, SOURCES, OTHERS) == set(ALLOWED)


def test_an_unused_definition_is_found_with_all_that_only_it_leads_to(tmp_path):
    (tmp_path / "setup.py").write_text("entry_points = ['start = shop.till:main']")
    shop = tmp_path / "shop"
    shop.mkdir()
    (shop / "__init__.py").write_text("from shop.prices import price, sale, tax\n")
    (shop / "prices.py").write_text(
        "def price(): return tax()\ndef tax(): ...\ndef sale(): return _half()\n"
        "def _half(): ...\nclass Bill:\n    def total(self): ...\n    def lost(self): ...\n"
    )
    (shop / "till.py").write_text(
        "from shop import prices\nfrom shop import price\n"
        "def main(): return price(), prices.Bill().total()\n"
    )
    expected = {"shop.prices:sale", "shop.prices:_half", "shop.prices:Bill.lost"}
    files = sorted(shop.glob("*.py"))
    assert names(tmp_path, files, [tmp_path / "setup.py"]) == expected
    (shop / "page.html").write_text("{{ bill.lost }}")
    files = sorted(shop.iterdir())
    expected = {"shop.prices:sale", "shop.prices:_half"}
    assert names(tmp_path, files, [tmp_path / "setup.py"]) == expected


def test_what_is_registered_or_taken_by_a_computed_name_is_used(tmp_path):
    (tmp_path / "__init__.py").write_text("")
    (tmp_path / "registry.py").write_text("def add(name):\n    return lambda f: f\n")
    (tmp_path / "laws.py").write_text(
        "from registry import add\n@add('x')\ndef law(): ...\ndef other(): ...\n"
    )
    (tmp_path / "doors.py").write_text("def first(): ...\ndef second(): ...\n")
    (tmp_path / "main.py").write_text("import doors\nnamed = getattr(doors, input())\n")
    assert names(tmp_path, sorted(tmp_path.glob("*.py"))) == {"laws:other"}
