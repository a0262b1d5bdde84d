"""Renders doctests as code blocks if they are outside a docstring's Examples section."""

import re

import griffe

# Matches a paragraph of doctest prompts, unless the line before it underlines a heading.
PARAGRAPH = re.compile(r"(?<!---\n)^(?P<code>>>> (?:.+\n?)+)", re.MULTILINE)


class Doctests(griffe.Extension):
    def on_instance(self, *, obj, **_):
        if obj.docstring and "\nExamples\n---" not in obj.docstring.value:
            obj.docstring.value = PARAGRAPH.sub(r"```pycon\n\g<code>\n```\n", obj.docstring.value)
