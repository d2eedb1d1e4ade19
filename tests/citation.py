# SPDX-License-Identifier: Apache-2.0
"""CITATION.cff keeps to the Citation File Format 1.2.0, as far as this project uses it: its schema's required keys, known keys and
types. Run in the project's root: python3 tests/citation.py. It first checks that it finds faults. Without PyYAML it ends with 77."""
import copy
import datetime
import re
import sys
from pathlib import Path

try:
    import yaml
except ImportError:
    sys.exit(77)

PERSON = {"address", "affiliation", "alias", "city", "country", "email", "family-names", "fax", "given-names",
          "name-particle", "name-suffix", "orcid", "post-code", "region", "tel", "website"}
ENTITY = {"address", "alias", "city", "country", "date-end", "date-start", "email", "fax", "location", "name", "orcid",
          "post-code", "region", "tel", "website"}
ROOT = {"abstract", "authors", "cff-version", "commit", "contact", "date-released", "doi", "identifiers", "keywords",
        "license", "license-url", "message", "preferred-citation", "references", "repository", "repository-artifact",
        "repository-code", "title", "type", "url", "version"}
# Of a reference, those that a paper or a book may have.
REFERENCE = {"abbreviation", "abstract", "authors", "collection-doi", "collection-title", "collection-type", "conference",
             "date-published", "doi", "edition", "editors", "end", "identifiers", "institution", "isbn", "issn", "issue",
             "journal", "keywords", "languages", "license", "location", "month", "notes", "number", "pages", "pmcid",
             "publisher", "section", "start", "status", "title", "type", "url", "version", "volume", "year"}
PAPERS = {"article", "book", "conference", "conference-paper", "generic", "manual", "pamphlet", "proceedings", "report",
          "software", "standard", "thesis", "unpublished"}


def faults(cff):
    """What is wrong, a line each."""
    found = []

    def fault_if(wrong, text):
        if wrong:
            found.append(text)

    def texts(place, table, keys):
        for key in keys & set(table):
            fault_if(not isinstance(table[key], str) or not table[key], f"{place}{key}: must be a text")

    def names(place, people):
        fault_if(not isinstance(people, list) or not people, f"{place}: must be a list")
        for person in people or []:
            known = ENTITY if "name" in person else PERSON
            fault_if(not person or set(person) - known, f"{place}: {set(person) - known} is unknown of {person}")
            texts(f"{place}.", person, {"name", "family-names", "given-names", "affiliation", "email"})
            orcid = person.get("orcid", "https://orcid.org/0000-0000-0000-0000")
            fault_if(not re.fullmatch(r"https://orcid\.org/\d{4}-\d{4}-\d{4}-\d{3}[0-9X]", orcid), f"{place}: {orcid}")

    def work(place, table, known, required):
        for key in required - set(table):
            found.append(f"{place}{key}: is missing")
        fault_if(set(table) - known, f"{place or 'CITATION.cff'}: unknown: {set(table) - known}")
        texts(place, table, {"abstract", "license", "message", "title", "collection-title", "journal", "notes"})
        names(f"{place}authors", table.get("authors"))
        keywords = table.get("keywords", ["a"])
        fault_if(not keywords or len(set(keywords)) < len(keywords) or not all(isinstance(w, str) for w in keywords),
                 f"{place}keywords: must be texts, each once")
        for key in ("url", "repository", "repository-code", "license-url"):
            fault_if(not re.match(r"(https?|s?ftp)://[^ ]+$", table.get(key, "https://a")), f"{place}{key}: must be a URL")
        fault_if(not re.match(r"10\.\d{4,9}(\.\d+)?/\S+$", table.get("doi", "10.1000/1")), f"{place}doi: must be a DOI")

    work("", cff, ROOT, {"authors", "cff-version", "message", "title"})
    fault_if(cff.get("cff-version") != "1.2.0", "cff-version: must be 1.2.0")
    fault_if(cff.get("type", "software") not in ("software", "dataset"), "type: must be software or dataset")
    fault_if(not isinstance(cff.get("version", "0"), (str, int, float)), "version: must be a text")
    fault_if(not isinstance(cff.get("date-released", datetime.date.today()), datetime.date), "date-released: must be a date")
    for i, reference in enumerate(cff.get("references", [])):
        place = f"references[{i}]."
        work(place, reference, REFERENCE, {"authors", "title", "type"})
        fault_if(reference.get("type") not in PAPERS, f"{place}type: {reference.get('type')} is unknown")
        if "conference" in reference:
            names(place + "conference", [reference["conference"]])
            fault_if("name" not in reference["conference"], f"{place}conference: has no name")
    return found


def self_test(cff):
    """Each of these breaks the file."""
    def broken(change):
        other = copy.deepcopy(cff)
        change(other)
        return faults(other)
    for change in (lambda c: c.pop("title"), lambda c: c.update(authors=[]), lambda c: c.update(author="a"),
                   lambda c: c.update({"date-released": "soon"}), lambda c: c["authors"].append({"surname": "a"}),
                   lambda c: c["references"][0].update(type="talk"), lambda c: c["references"][0].pop("authors"),
                   lambda c: c.update(doi="doi:10"), lambda c: c.update(keywords=["a", "a"])):
        if not broken(change):
            sys.exit("citation.py finds no fault where there is one")


citation = yaml.safe_load(Path("CITATION.cff").read_text())
self_test(citation)
wrong = faults(citation)
if wrong:
    sys.exit("CITATION.cff:\n  " + "\n  ".join(wrong))
print("CITATION.cff keeps to the format.")
