"""Names: validation, expansion, and renaming rules (``from:=to``)."""

from __future__ import annotations

import re
from dataclasses import dataclass

_WORD = r"[A-Za-z_][A-Za-z0-9_]*"
_NODE = re.compile(rf"{_WORD}\Z")
_FROM = re.compile(rf"(rostopic://|rosservice://)?(~/|/)?{_WORD}(/{_WORD})*\Z")
_TO = re.compile(rf"(~/|/)?{_WORD}(/{_WORD})*\Z|~\Z")


@dataclass(frozen=True)
class Rule:
    """A renaming rule.

    :param kind: ``'node'``, ``'namespace'``, ``'topic'``, ``'service'`` or ``'any'``.
    :param source: the name it applies to (topics and services only).
    :param target: the new name.
    :param node: name of the only node it applies to, ``None`` for all.
    """

    kind: str
    source: str
    target: str
    node: str | None = None


def parse_rule(text: str) -> Rule:
    """Read ``[node:]from:=to``.

    :raises ValueError: if it is not such a rule.
    """
    left, assigned, target = text.partition(":=")
    if not assigned:
        raise ValueError(f"{text!r} is not a remap rule: there is no ':='")
    node = None
    scheme = re.match(r"(rostopic|rosservice)://", left)
    head, colon, rest = left.partition(":")
    if colon and not scheme:
        if not _NODE.match(head):
            raise ValueError(f"{head!r} is not a node name")
        node, left = head, rest
    if left in ("__node", "__name"):
        if not _NODE.match(target):
            raise ValueError(f"{target!r} is not a node name")
        return Rule("node", "", target, node)
    if left == "__ns":
        if namespace_error(target):
            raise ValueError(f"{target!r} is not a namespace")
        return Rule("namespace", "", target, node)
    if not _FROM.match(left) or not _TO.match(target):
        raise ValueError(f"{text!r} is not a remap rule: {left!r} or {target!r} is not a name")
    kind = {"rostopic": "topic", "rosservice": "service"}.get(scheme.group(1) if scheme else "")
    return Rule(kind or "any", left.split("://")[-1], target, node)


def renamed_node(rules: list[Rule], name: str) -> str:
    """Return the name a node gets: the first rule that applies wins."""
    for rule in rules:
        if rule.kind == "node" and rule.node in (None, name):
            return rule.target
    return name


def renamed_namespace(rules: list[Rule], name: str, namespace: str) -> str:
    """Return the namespace a node gets."""
    for rule in rules:
        if rule.kind == "namespace" and rule.node in (None, name):
            return rule.target
    return namespace


def expand(name: str, node: str, namespace: str) -> str:
    """Return the full name of a topic, service or action.

    :param name: relative, private (``~``) or full name; ``{node}``, ``{ns}`` and
        ``{namespace}`` are replaced.
    """
    name = name.replace("{node}", node).replace("{ns}", namespace)
    name = name.replace("{namespace}", namespace)
    base = "" if namespace == "/" else namespace
    if name.startswith("~"):
        name = f"{base}/{node}{name[1:]}"
    elif not name.startswith("/"):
        name = f"{base}/{name}"
    return name


def remap(rules: list[Rule], full: str, kind: str, node: str, namespace: str) -> str:
    """Apply the first rule that fits a full name.

    :param kind: ``'topic'`` or ``'service'``.
    """
    for rule in rules:
        applies = rule.kind in (kind, "any") and rule.node in (None, node)
        if applies and expand(rule.source, node, namespace) == full:
            return expand(rule.target, node, namespace)
    return full


def node_name_error(name: str) -> tuple[str, int] | None:
    """Return what is wrong with a node name and where, ``None`` if nothing is."""
    if not name:
        return "node name must not be empty", 0
    if bad := re.search(r"[^A-Za-z0-9_]", name):
        return (
            "node name must not contain characters other than alphanumerics or '_'",
            bad.start(),
        )
    if name[0].isdigit():
        return "node name must not start with a number", 0
    if len(name) > 255:
        return "node name length should not exceed '255'", 254
    return None


def namespace_error(name: str) -> tuple[str, int] | None:
    """Return what is wrong with a namespace and where, ``None`` if nothing is."""
    if not name:
        return "namespace must not be empty", 0
    if not name.startswith("/"):
        return "namespace must be absolute, it must lead with a '/'", 0
    if name == "/":
        return None
    if name.endswith("/"):
        return "namespace must not end with a '/', unless only a '/'", len(name) - 1
    return _path_error(name, "namespace")


def full_name_error(name: str, what: str) -> tuple[str, int] | None:
    """Return what is wrong with a full topic or service name and where."""
    if not name:
        return f"{what} must not be empty", 0
    if not name.startswith("/"):
        return f"{what} must be absolute, it must lead with a '/'", 0
    if name.endswith("/"):
        return f"{what} must not end with a '/'", len(name) - 1
    return _path_error(name, what)


def _path_error(name: str, what: str) -> tuple[str, int] | None:
    if bad := re.search(r"[^A-Za-z0-9_/]", name):
        message = f"{what} must not contain characters other than alphanumerics, '_', or '/'"
        return message, bad.start()
    if (at := name.find("//")) >= 0:
        return f"{what} must not contain repeated '/'", at + 1
    if bad := re.search(r"/[0-9]", name):
        return f"{what} must not have a token that starts with a number", bad.start() + 1
    if len(name) > 247:
        if what == "namespace":
            return "namespace should not exceed 'RMW_NAMESPACE_MAX_NAME_LENGTH'", 244
        return "topic length should not exceed '255U - 8U'", 246
    return None


def topic_name_error(name: str) -> tuple[str, int] | None:
    """Return what is wrong with a topic or service name (not yet expanded) and where."""
    if not name:
        return "topic name must not be empty string", 0
    if name.endswith("/"):
        return "topic name must not end with a forward slash", len(name) - 1
    opened = -1
    unbalanced = "topic name must not have unmatched (unbalanced) curly braces '{}'"
    for at, char in enumerate(name):
        if char == "{":
            if opened >= 0:
                return unbalanced, at
            opened = at
        elif char == "}":
            if opened < 0:
                return unbalanced, at
            opened = -1
        elif char == "~" and at:
            return "topic name must not have tilde '~' unless it is the first character", at
        elif not re.match(r"[A-Za-z0-9_/~]", char):
            return (
                "topic name must not contain characters other than alphanumerics, '_', '~', "
                "'{', or '}'",
                at,
            )
        elif char.isdigit() and (at == 0 or name[at - 1] == "/"):
            return "topic name token must not start with a number", at
    if opened >= 0:
        return unbalanced, opened
    return None


def unknown_substitution(name: str) -> str | None:
    """Return the first ``{...}`` of a name that stands for nothing, ``None`` if all do."""
    for found in re.findall(r"\{[^}]*\}", name):
        if found not in ("{node}", "{ns}", "{namespace}"):
            return str(found)
    return None
