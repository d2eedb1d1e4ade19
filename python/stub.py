# SPDX-License-Identifier: Apache-2.0
"""Writes the docstrings of the compiled part into its stub, thenar/_core.pyi, where editors read them.

Names, parameters and types are the stub's own. Run it with the package: ./dev python python/stub.py
With --check it writes nothing, and ends with 1 where the stub is not current.
"""
import ast
import inspect
import sys
import textwrap
from pathlib import Path

STUB = Path(__file__).resolve().parent / "thenar" / "_core.pyi"
WIDTH = 120


def docstring_of(thing, name):
    """What the module says of a name, without the signature that pybind11 puts before it."""
    doc = inspect.cleandoc(getattr(thing, "__doc__", None) or "")
    if doc.startswith(f"{name}("):
        return doc.partition("\n")[2].strip()
    return "" if name.startswith("__") else doc  # Python's own, of every class


def as_source(doc, indent):
    """A docstring as lines of source."""
    width = WIDTH - len(indent)
    lines = []
    for paragraph in f'"""{doc}"""'.split("\n\n"):
        own = paragraph.splitlines()
        if any(len(line) > width for line in own):
            own = textwrap.wrap(" ".join(own), width, break_long_words=False, break_on_hyphens=False)
        lines += ["", *own] if lines else own
    if "\n" in doc or len(lines) > 1:  # As in this project's sources, the quotes that close stand alone.
        lines[-1:] = [lines[-1][:-3], '"""']
    return "".join(f"{indent}{line}".rstrip() + "\n" for line in lines)


def edits(body, module, lines):
    """(first line, end line, text) of each definition's head with its docstring, from the last one up."""
    for node in body:
        if not isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            continue
        thing = inspect.getattr_static(module, node.name, None)
        is_setter = any(isinstance(one, ast.Attribute) and one.attr == "setter" for one in node.decorator_list)
        doc = "" if is_setter else docstring_of(thing, node.name)
        indent = " " * (node.col_offset + 4)
        first = node.body[0]
        is_docstring = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and isinstance(
            first.value.value, str)
        if isinstance(node, ast.ClassDef):
            if doc or is_docstring:
                end = first.end_lineno if is_docstring else node.lineno
                yield node.lineno, end, lines[node.lineno - 1] + (as_source(doc, indent) if doc else "")
            yield from edits(node.body, thing, lines)
            continue
        head = "".join(lines[node.lineno - 1:first.lineno - 1])  # `def` to the colon
        if not is_docstring:
            head += lines[first.lineno - 1][:first.col_offset]
        yield node.lineno, first.end_lineno, head.rstrip() + ("\n" + as_source(doc, indent) if doc else " ...\n")


def current(text):
    """The stub with the docstrings of the module that is imported."""
    # The package beside this file has no compiled part.
    sys.path[:] = [folder for folder in sys.path if Path(folder).resolve() != STUB.parents[1]]
    from thenar import _core

    lines = text.splitlines(keepends=True)
    for first, end, new in sorted(edits(ast.parse(text).body, _core, lines), reverse=True):
        lines[first - 1:end] = [new]
    return "".join(lines)


def main():
    text = STUB.read_text(encoding="utf-8")
    new = current(text)
    if sys.argv[1:] == ["--check"]:
        if new != text:
            sys.exit(f"{STUB} is not current. Renew it with: ./dev python python/stub.py")
    else:
        STUB.write_text(new, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
