"""What a C++ header of the core offers as templates, and a program that instantiates all of it.

The list is read off the header's text, so that nothing new can be left out: a template parameter
that nobody has said a value for is an error, as is a `template` that the reader has not understood.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

NOT_IN_AN_INSTANTIATION = (
    r"(\b(inline|constexpr|static|explicit|friend|OMNIMORPH_FN)\b|\[\[[^]]*\]\])\s*"
)
Choices = Callable[[str], list[dict[str, str]]]  # of template arguments, for the name of a template
CLOSING = {"(": ")", "[": "]", "{": "}", "<": ">"}


@dataclass(frozen=True)
class Template:
    """A class, function, variable or alias of a header that needs template arguments."""

    kind: str  # struct, class, function, friend, variable, alias
    name: str  # of a function with its parameters, of a class with the arguments it is special for
    namespaces: tuple[str, ...]
    owner: str  # the class around it with its arguments, or nothing
    parameters: tuple[str, ...]  # with those of the owner
    own_parameters: tuple[str, ...]
    returned: str = ""
    arguments: str = ""
    suffix: str = ""


@dataclass
class Reader:
    """Goes through a header once; `found` are its templates, `understood` counts the keyword."""

    text: str
    found: list[Template] = field(default_factory=list)
    functions: list[str] = field(default_factory=list)  # what stands before the body of each
    understood: int = 0

    def read(self) -> list[Template]:
        """Return the templates of the header, every one of them."""
        self.read_block(0, (), "", ())
        written = len(re.findall(r"(?<![.:>] )(?<!\.)\btemplate <", self.text))
        assert self.understood == written, f"{self.understood} of {written} templates understood"
        return self.found

    def read_block(
        self, at: int, spaces: tuple[str, ...], owner: str, outer: tuple[str, ...]
    ) -> int:
        """Read the declarations of a namespace or class; return where it ends."""
        begin = at
        while at < len(self.text):
            character = self.text[at]
            if character in "([":
                at = end_of(self.text, at)
            elif character == "}":
                return at
            elif character == ":" and re.fullmatch(
                r"\s*(public|private|protected)", self.text[begin:at]
            ):
                begin = at + 1
            elif character == ";":
                self.read_declaration(self.text[begin:at], spaces, owner, outer)
                begin = at + 1
            elif character == "{":
                head = self.text[begin:at].strip()
                end = end_of(self.text, at)
                if head.startswith("namespace"):
                    inside = tuple(head.split()[1].split("::"))
                    self.read_block(at + 1, (*spaces, *inside), "", ())
                    begin = end + 1
                elif is_class(head):
                    name, parameters = self.read_class(head, spaces, owner, outer)
                    self.read_block(at + 1, spaces, name, parameters)
                    begin = end + 1  # of what follows, `;` is left
                elif is_function(head) and not re.match(r"\s*[,{]", self.text[end + 1 :]):
                    self.read_function(head, spaces, owner, outer)
                    begin = end + 1
                at = end
            at += 1
        return at

    def split(self, head: str) -> tuple[tuple[str, ...], str]:
        """Return the names of template parameters, and what follows `template <...>`."""
        if not head.startswith("template"):
            return (), head
        begin = head.index("<")
        end = end_of(head, begin)
        self.understood += 1
        named = []
        for parameter in parted(head[begin + 1 : end]):
            match = re.match(r"(?:[\w:]+)(?:\.\.\.)? (\w+)", parameter)
            if match:
                named.append(match.group(1))
        return tuple(named), head[end + 1 :].strip()

    def read_class(
        self, head: str, spaces: tuple[str, ...], owner: str, outer: tuple[str, ...]
    ) -> tuple[str, tuple[str, ...]]:
        own, rest = self.split(head)
        match = re.match(r"(struct|class) (\w+)\s*(<.*>)?", rest)
        assert match is not None, head
        special = match.group(3) or (f"<{', '.join(own)}>" if own else "")
        name = (f"{owner}::" if owner else "") + match.group(2) + special
        parameters = (*outer, *own)
        if own:  # otherwise it is instantiated with the class around it, if there is one
            self.found.append(Template(match.group(1), name, spaces, owner, parameters, own))
        return name, parameters

    def read_function(
        self, head: str, spaces: tuple[str, ...], owner: str, outer: tuple[str, ...]
    ) -> None:
        self.functions.append(head)
        own, rest = self.split(head)
        is_friend = rest.startswith("friend")
        if not own and not (is_friend and outer):
            return  # compiled as it stands, or with its class
        rest = re.sub(NOT_IN_AN_INSTANTIATION, "", rest)
        match = re.match(r"(?s)(.*?)(\boperator\s*(?:\(\)|[^\s\w(]+|\w+)|\w+)\s*\(", rest)
        assert match is not None, head
        end = end_of(rest, match.end() - 1)
        arguments = ", ".join(
            re.sub(r"\s*=.*", "", part) for part in parted(rest[match.end() : end])
        )
        suffix = "const" if rest[end + 1 :].strip().startswith("const") else ""
        kind = "friend" if is_friend else "function"
        self.found.append(
            Template(
                kind,
                match.group(2),
                spaces,
                owner,
                (*outer, *own),
                own,
                match.group(1).strip(),
                arguments,
                suffix,
            )
        )

    def read_declaration(
        self, text: str, spaces: tuple[str, ...], owner: str, outer: tuple[str, ...]
    ) -> None:
        head = text.strip()
        if not head.startswith("template") and not owner:
            return
        own, rest = self.split(head)
        if not own:
            return
        alias = re.match(r"using (\w+)", rest)
        variable = re.match(r"inline constexpr (?:\w+) (\w+)\s*(<[^=]*>)?\s*[={]", rest + "=")
        if alias:
            self.found.append(Template("alias", alias.group(1), spaces, owner, own, own))
        elif variable and not variable.group(2) and "(" not in rest.split("=")[0]:
            self.found.append(Template("variable", variable.group(1), spaces, owner, own, own))
        # what is left is declared here and defined elsewhere, or special for some arguments


def end_of(text: str, begin: int) -> int:
    """Return where the bracket at `begin` closes."""
    opening, closing = text[begin], CLOSING[text[begin]]
    depth = 0
    for at in range(begin, len(text)):
        depth += (text[at] == opening) - (text[at] == closing)
        if depth == 0:
            return at
    raise AssertionError(f"{opening} never closes: {text[begin : begin + 60]}")


def parted(text: str) -> list[str]:
    """Return what commas separate outside of all brackets."""
    parts, depth, begin = [], 0, 0
    for at, character in enumerate(text):
        depth += (character in "(<[{") - (character in ")>]}")
        if character == "," and depth == 0:
            parts.append(text[begin:at].strip())
            begin = at + 1
    return [part for part in [*parts, text[begin:].strip()] if part]


def after_template(head: str) -> str:
    """Return a declaration without its `template <...>`."""
    return (
        head[end_of(head, head.index("<")) + 1 :].strip() if head.startswith("template") else head
    )


def is_class(head: str) -> bool:
    """Whether what stands before a brace declares a class."""
    return re.match(r"(struct|class)\b", after_template(head)) is not None


def is_function(head: str) -> bool:
    """Whether what stands before a brace declares a function."""
    rest = after_template(head)
    return "(" in rest and "=" not in re.sub(r"operator\s*\S+?\(", "(", rest).split("(")[0]


def plain(text: str) -> str:
    """Return C++ without comments, preprocessor lines and what stands in quotes."""
    text = re.sub(r'"(\\.|[^"\\\n])*"', '""', text)
    text = re.sub(r"(?<![0-9a-fA-F])'(\\.|[^'\\\n])'", "' '", text)
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.DOTALL)
    return re.sub(r"^[ \t]*#(\\\n|[^\n])*", "", text, flags=re.MULTILINE)


def functions_of(text: str) -> list[str]:
    """Return the declaration of every function that a header defines, members too."""
    reader = Reader(plain(text))
    reader.read()
    return reader.functions


def templates_of(text: str) -> list[Template]:
    """Return every template that a header defines."""
    return Reader(plain(text)).read()


def with_values(text: str, values: Mapping[str, str]) -> str:
    """Put the values of template parameters in their places."""
    for name, value in values.items():
        text = re.sub(rf"\b{name}\b(?:\.\.\.)?", value, text)
    return text


def instantiation(template: Template, values: Mapping[str, str], number: int) -> str:
    """Return the lines that instantiate a template with these arguments."""
    chosen = {name: values[name] for name in template.parameters}
    own = ", ".join(chosen[name] for name in template.own_parameters)
    owner = with_values(template.owner, chosen)
    arguments = with_values(template.arguments, chosen)
    if template.kind in ("struct", "class"):
        line = f"template {template.kind} {with_values(template.name, chosen)};"
    elif template.kind == "function":
        qualified = (f"{owner}::" if owner else "") + template.name
        packs = [name for name in template.own_parameters if f"{name}..." in template.arguments]
        if not template.returned or packs not in ([], [*template.own_parameters[-1:]]):
            own = ""  # deduced: of a constructor, and where others follow a pack
        arguments = arguments.replace("...", "")  # of packs, each of one argument
        returned = with_values(template.returned, chosen)
        given = f"<{own}>" if own else ""
        line = f"template {returned} {qualified}{given}({arguments}) {template.suffix};"
    elif template.kind == "friend":
        names = ", ".join(re.findall(r"(\w+)\s*$", part)[0] for part in parted(arguments))
        called = f"(void){template.name}({names});"
        line = f"struct Friend{number} : {owner} {{ void call({arguments}) {{ {called} }} }};"
    else:
        scope = f"{owner}::" if owner else ""
        used = f"{scope}{template.name}<{own}>"
        line = (
            f"using Alias{number} = {used};"
            if template.kind == "alias"
            else f"inline constexpr auto variable_{number} = {used};"
        )
    begin = "".join(f"namespace {name} {{ " for name in template.namespaces)
    return begin + line + " }" * len(template.namespaces)


def program(header: str, text: str, choices: Choices, before: str = "") -> str:
    """Return a program that includes a header and instantiates all of its templates."""
    lines = dict.fromkeys(instantiations(templates_of(text), choices))
    return "\n".join([f'#include "{header}"', PREAMBLE, before, *lines, ""])


def instantiations(templates: list[Template], choices: Choices) -> Iterator[str]:
    """Each template with each choice of arguments; what is the same is the same line."""
    for number, template in enumerate(templates):
        name = re.sub(r"<.*", "", template.name)
        for k, values in enumerate(choices(name)):
            unknown = [one for one in template.parameters if one not in values]
            assert not unknown, f"{template.name}: no value for {unknown}"
            yield instantiation(template, values, 10 * number + k)


PREAMBLE = """
#include "omnimorph/math/pack.hpp"
namespace omnimorph {
struct Called { template <class... X> void operator()(X&&...) const {} };
struct Answered { template <class... X> bool operator()(X&&...) const { return true; } };
}
"""
