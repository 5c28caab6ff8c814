"""LaTeX → the plain spelling of the notation, every character with its place.

What is printed as ``\\phi_{fr}|_{\\tau_{fr}(\\Gamma)}^{\\sigma_{fr}(\\Gamma)}`` is turned into ``φ_fr|τ_fr(Γ) σ_fr(Γ)``
before the grammar sees it, so that there is one grammar, and one set of complaints, for all spellings.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

from graspdsl.diagnostics import SourceText, nearest
from graspdsl.notation.characters import fold, shown
from graspdsl.notation.fault import Fault
from graspdsl.notation.greek import LETTERS
from graspdsl.notation.reading import Reading

MOST_GROUPS = 64  # one within another
MOST_FAULTS = 20
MOST_CHARACTERS = 10_000  # written and in the plain spelling, where a set that stands for both sides is there twice

_SIGN = re.compile(r"[\\^$]|_\s*\{")
_TOKEN = re.compile(r"\\(?:[A-Za-z]+\*?|.|\Z)|%[^\n]*|\s+|[A-Za-zΑ-Ωα-ω0-9]+|.", re.DOTALL)
_WIDE = "\u2003"  # \quad, which an equation's number comes behind
_STOPS = " .,;\n\t\r" + _WIDE
_NUMBER = re.compile(r"\((?:[A-Z][\d.]*\d|[1-9]\d*(?:\.\d+)*)[a-z]?\)")  # not 0.5, a reference
_NAME = re.compile(r"\w+")
_POWER = re.compile(r"(?:(?<![\w.])([0-9.]+) *× *)?(?<![\w.])10\Z")

_BARS = {"|", "\\vert", "\\mid", "\\lvert", "\\rvert"}
_SIZES = {
    *("\\left", "\\right", "\\middle"),
    *(f"\\{size}{side}" for size in ("big", "Big", "bigg", "Bigg") for side in ("", "l", "r", "m")),
}
_IGNORED = {
    *("\\displaystyle", "\\textstyle", "\\scriptstyle", "\\limits", "\\nolimits", "\\nonumber", "\\notag", "\\hfill"),
    *("\\bf", "\\rm", "\\it", "\\sf", "\\tt", "\\cal", "\\boldmath", "\\mathstrut", "\\strut", "\\relax", "\\null"),
    *("\\!", "\\/", "\\-", "\\(", "\\)", "\\[", "\\]", "$"),
}
_SPACES = {
    *("\\,", "\\:", "\\;", "\\>", "\\ ", "\\\n", "\\\\", "~"),
    *("\\newline", "\\thinspace", "\\enspace", "\\space", "\\allowbreak"),
}
_WIDE_SPACES = {"\\quad", "\\qquad", "&", "\\eqno", "\\leqno"}
# Commands that say nothing of the formula, with what they take in braces.
_DROPPED = {
    *("\\label", "\\tag", "\\tag*", "\\hspace", "\\hspace*", "\\vspace", "\\vspace*", "\\ref", "\\eqref", "\\cite"),
    *("\\phantom", "\\hphantom", "\\vphantom", "\\color"),
}
_FONTS = {
    f"\\{font}"
    for font in (
        *("mathbf", "mathrm", "mathit", "mathsf", "mathtt", "mathnormal", "boldsymbol", "bm", "pmb", "vec"),
        *("operatorname", "operatorname*", "mathop", "mathbin", "mathrel", "mathord", "mathopen", "mathclose"),
        *("mathinner", "ensuremath"),
    )
}
_TEXTS = {
    f"\\{font}"
    for font in ("text", "textrm", "textit", "textbf", "textsf", "texttt", "textnormal", "mbox", "hbox", "emph")
}
_ABOVE = {"\\stackrel", "\\overset", "\\underset"}  # whose first argument is an ornament
_ENVIRONMENTS = {
    f"{name}{star}"
    for name in (
        *("equation", "align", "gather", "multline", "eqnarray", "flalign", "alignat", "displaymath", "math"),
        *("dmath", "IEEEeqnarray"),
        *("split", "aligned", "gathered", "subequations"),
    )
    for star in ("", "*")
}


_WITH_COLUMNS = {"alignat", "IEEEeqnarray"}  # whose names a number or a scheme of columns follows


def _printed(signs: str) -> dict[str, str]:
    """Signs by their commands: ``"◁ triangleleft lhd"`` a line."""
    return {
        f"\\{command}": sign for sign, *commands in map(str.split, signs.strip().splitlines()) for command in commands
    }


_SIGNS = {
    **_printed(r"""
        ◁ triangleleft lhd vartriangleleft
        { { lbrace
        } } rbrace
        < langle lt
        > rangle gt
        ( lparen
        ) rparen
        _ _ textunderscore
        ≡ equiv triangleq coloneqq Coloneqq coloneq doteq defeq eqdef
    """),
    # What is no sign of the notation, and is told so by the sign that it prints.
    **_printed(r"""
        # #
        % %
        & &
        ⋉ ltimes
        ⋊ rtimes
        ⊴ trianglelefteq unlhd
        ∘ circ bullet
        ▷ triangleright rhd vartriangleright
        ≺ blacktriangleleft prec preceq ll
        ≻ succ succeq gg
        → to rightarrow longrightarrow mapsto
        ⇒ Rightarrow Longrightarrow implies
        ← gets leftarrow longleftarrow
        + oplus
        ∧ wedge land
        ∨ vee lor
        ⊂ subset subseteq
        ∈ in
        ∪ cup
        ∩ cap
        ± pm
        … ldots dots cdots
    """),
}
_GREEK = {
    **{f"\\{word}": letter for word, letter in LETTERS.items()},
    **{f"\\var{word}": LETTERS[word] for word in ("phi", "theta", "epsilon", "sigma", "rho", "pi", "kappa")},
    **{f"\\var{word}": letter for word, letter in LETTERS.items() if word[0].isupper()},
}
# What equations of gradients, sums and rotations are made of; and matrices, as environments.
_OF_LAWS = {
    f"\\{word}"
    for word in (
        *("nabla", "partial", "frac", "dfrac", "tfrac", "sum", "prod", "int", "sin", "cos", "tan", "sqrt", "mathcal"),
        *("matrix", "pmatrix", "bmatrix", "lim", "min", "max", "arg", "argmin", "exp", "log", "top", "dagger"),
        *("dot", "ddot", "forall", "mathbb"),
    )
}
_KNOWN = [
    *_GREEK,
    *(command for command, sign in _SIGNS.items() if sign in "◁{}<>()_≡"),
    *_FONTS,
    *_TEXTS,
    *_BARS,
    *_SIZES,
    *_SPACES,
    *_IGNORED,
    *_DROPPED,
]
_PRODUCTS = {"\\cdot", "\\times", "\\ast"}

_SUPERSCRIPT = r"\phi_{fr}|_{\tau_{fr}(\Gamma)}^{\sigma_{fr}(\Gamma)}"
_POTENTIAL = re.compile(r"\\(?:var)?phi_\{?([A-Za-z0-9]+)\}?")


def is_latex(text: str) -> bool:
    """Whether a text is LaTeX: it has a command, a superscript, a dollar sign or a subscript in braces."""
    return len(text) <= MOST_CHARACTERS and _SIGN.search(text) is not None


def reading_of(source: SourceText) -> tuple[Reading, list[Fault]]:
    """The reading of a formula in any spelling, and what of its LaTeX cannot be read, by offsets in the source."""
    if not is_latex(source.text):
        return Reading.plain(source), []
    pieces, faults = _Transcriber(fold(source.text)).transcribed()
    text = _without_number("".join(piece.character for piece in pieces))
    end = pieces[len(text)].start if len(text) < len(pieces) else len(source.text)
    kept = pieces[: len(text)]
    return Reading(text, text, source, [piece.start for piece in kept], [piece.end for piece in kept], end), faults


def plain(text: str) -> str:
    """A text in plain spelling, its characters folded; LaTeX that cannot be read as it stands."""
    folded = fold(text)
    if not is_latex(folded):
        return folded
    pieces, faults = _Transcriber(folded).transcribed()
    return folded if faults else _without_number("".join(piece.character for piece in pieces))


@dataclass(frozen=True, slots=True)
class _Piece:
    """A character of the plain spelling and where it comes from; ``ends_atom``: no letter can be added to the name."""

    character: str
    start: int
    end: int
    ends_atom: bool = False


@dataclass(frozen=True, slots=True)
class _Token:
    text: str
    start: int
    end: int


class _StopError(Exception):
    """There is no use in reading on."""


class _Transcriber:
    def __init__(self, text: str) -> None:
        self._text = text
        self._tokens = [_Token(match.group(), *match.span()) for match in _TOKEN.finditer(text)]
        self._at = self._depth = 0
        self._within_name = False  # below, where letters make one name and a subscript goes on with it
        self._faults: list[Fault] = []

    def transcribed(self) -> tuple[list[_Piece], list[Fault]]:
        pieces: list[_Piece] = []
        try:
            while self._at < len(self._tokens):
                pieces += self._sequence()
                if self._at < len(self._tokens):
                    brace = self._next()
                    self._fault(brace, "unbalanced-bracket", "“}” closes nothing", "remove it, or open “{” before it")
        except _StopError:
            pass
        return pieces, self._faults

    # --- tokens -------------------------------------------------------------------------------------------------

    def _peek(self) -> str:
        return self._tokens[self._at].text if self._at < len(self._tokens) else ""

    def _next(self) -> _Token:
        self._at += 1
        return self._tokens[self._at - 1]

    def _skip_blanks(self, more: Iterable[str] = ()) -> None:
        while self._peek() and (self._peek().isspace() or self._peek()[0] == "%" or self._peek() in more):
            self._at += 1

    def _fault(self, token: _Token, code: str, message: str, hint: str) -> None:
        self._faults.append(Fault(token.start, token.end, code, message, hint))
        if len(self._faults) == MOST_FAULTS:
            raise _StopError

    # --- groups and items -----------------------------------------------------------------------------------------

    def _sequence(self) -> list[_Piece]:
        """What is read up to a brace that closes a group, or to the end."""
        pieces: list[_Piece] = []
        while self._peek() not in ("", "}"):
            self._item(pieces)
        return pieces

    def _group(self) -> list[_Piece]:
        """What stands in the braces that open here."""
        opening = self._next()
        pieces = self._sequence()
        if self._peek() != "}":
            self._fault(opening, "unbalanced-bracket", "“{” is not closed", "add the missing “}”")
            raise _StopError
        self._next()
        return pieces

    def _argument(self, *, of_name: bool = True) -> list[_Piece]:
        """What a command, ``_`` or ``^`` takes: a group, or one item; braces around a whole group change nothing."""
        before = self._at
        self._skip_blanks()
        if self._peek() == "{":
            pieces = _stripped(self._group())
            if pieces and of_name:  # whose closing brace a complaint shows, too
                pieces[-1] = replace(pieces[-1], end=self._tokens[self._at - 1].end)
            return pieces
        if self._peek() in ("", "}", "_", "^", "&", "$"):
            self._nothing_behind(self._tokens[before - 1])
            return []
        pieces = []
        self._item(pieces)
        return _stripped(pieces)

    def _nothing_behind(self, token: _Token) -> None:
        message = f"nothing stands behind {_shown(token.text)}"
        self._fault(token, "unexpected-end", message, "write what belongs there, in braces")

    def _item(self, pieces: list[_Piece]) -> None:
        """Reads one item and adds it."""
        token = self._tokens[self._at]
        self._depth += 1
        if self._depth > MOST_GROUPS:
            message, hint = f"this nests deeper than {MOST_GROUPS} levels here", "leave out braces that change nothing"
            self._fault(token, "too-deep", message, hint)
            raise _StopError
        self._read(self._next(), pieces)
        self._depth -= 1
        if len(pieces) > MOST_CHARACTERS:
            message = f"written out, this formula has more than {MOST_CHARACTERS} characters"
            self._fault(token, "too-long", message, "define parts of the formula under names of their own")
            raise _StopError

    def _read(self, token: _Token, pieces: list[_Piece]) -> None:
        text = token.text
        if text in _BARS:
            self._bar(token, pieces)
        elif text == "{":
            self._at -= 1
            self._bare_group(pieces)
        elif text == "_":
            self._subscript(token, pieces)
        elif text == "^":
            self._superscript(token, pieces)
        elif text[0] == "%" or text in _IGNORED:
            pass
        elif text.isspace() or text in _SPACES:
            pieces.append(_Piece(" ", token.start, token.end))
            if text == "\\\\" and self._peek() == "[":
                self._optional()
        elif text in _WIDE_SPACES:
            pieces.append(_Piece(_WIDE, token.start, token.end))
        elif text[0] == "\\":
            self._command(token, pieces)
        elif text == "#":
            message = "“#” stands for what a macro is given, and this is no macro"
            self._fault(token, "unexpected-character", message, "write what stands in its place, or remove it")
        else:
            self._add(pieces, [_Piece(c, token.start + i, token.start + i + 1) for i, c in enumerate(text)])

    def _optional(self) -> None:
        """Passes over ``[…]`` behind a command."""
        while self._peek() not in ("", "]", "}"):
            self._at += 1
        if self._peek() == "]":
            self._at += 1

    def _add(self, pieces: list[_Piece], more: list[_Piece], *, atom: bool = False) -> None:
        """Adds pieces; ``atom``: as a symbol of their own, which does not go on with the letters before it."""
        before = pieces[-1] if pieces else None
        touching = more and before and _is_letter(before.character) and _is_letter(more[0].character)
        if before and touching and (before.ends_atom or (atom and not self._within_name)):
            pieces.append(_Piece(" ", more[0].start, more[0].start))
        pieces += more

    # --- scripts --------------------------------------------------------------------------------------------------

    def _bar(self, bar: _Token, pieces: list[_Piece]) -> None:
        """``|_{…}^{…}`` in either order: effector side, then sensor side; one set stands for both without the other."""
        sides: dict[str, list[_Piece]] = {}
        pieces.append(_Piece("|", bar.start, bar.end))
        while True:
            before = self._at
            self._skip_blanks(("\\!", "\\,", "\\nolimits", "\\limits"))
            if self._peek() not in ("_", "^"):
                self._at = before
                break
            script = self._next()
            if script.text in sides:
                what = "subscript" if script.text == "_" else "superscript"
                self._fault(
                    script, "unexpected-sign", f"the bar has a second {what}", "write both in one pair of braces"
                )
            sides[script.text] = _as_side(self._outside_of_names())
        if not sides:
            return
        below, above = sides.get("_", []), sides.get("^", [])
        if not above and below and below[0].character not in "τσ":
            above = below
        pieces += below
        if below and above:
            pieces.append(_Piece(" ", above[0].start, above[0].start))
        pieces += above
        if above or below:
            behind = self._tokens[self._at - 1].end
            pieces.append(_Piece(" ", behind, behind))

    def _outside_of_names(self) -> list[_Piece]:
        within, self._within_name = self._within_name, False
        pieces = self._argument(of_name=False)
        self._within_name = within
        return pieces

    def _bare_group(self, pieces: list[_Piece]) -> None:
        """Braces that only hold together; such as hold a list are a set, which is what was meant."""
        start = self._tokens[self._at].start
        inner = self._group()
        end = self._tokens[self._at - 1].end
        if _has_comma(inner):
            pieces += [_Piece("{", start, start + 1), *inner, _Piece("}", end - 1, end)]
        else:
            self._add(pieces, inner, atom=True)

    def _subscript(self, sign: _Token, pieces: list[_Piece]) -> None:
        while pieces and pieces[-1].character == " " and self._within_name:
            pieces.pop()
        while len(pieces) > 1 and pieces[-1].character.isspace() and _is_letter(pieces[-2].character):
            pieces.pop()
        within, self._within_name = self._within_name, True
        inner = [piece for piece in self._argument() if not piece.character.isspace()]
        self._within_name = within
        if not inner:
            return
        text = "".join(piece.character for piece in inner)
        token = _Token(self._text[sign.start : inner[-1].end], sign.start, inner[-1].end)
        base = _base(pieces)
        if not _NAME.fullmatch(text):
            self._no_name(token, base, text)
            return
        # What is below a subscript goes on with it: τ_{fr_x} is τ_frx.
        start = [] if within else [_Piece("_", sign.start, sign.end)]
        last = inner[-1]
        pieces += [*start, *inner[:-1], replace(last, ends_atom=True)]

    def _no_name(self, token: _Token, base: str, text: str) -> None:
        members = re.fullmatch(r"[1-9](?:,[1-9])+", text)
        if base in ("γ", "Γ") and members:
            contacts = ", ".join(rf"\gamma_{digit}" for digit in text.split(","))
            hint = rf"contacts that act as one are written \langle {contacts} \rangle"
        elif any(sign in text for sign in "({<"):
            hint = rf"transforms and resources stand at a bar: {_SUPERSCRIPT}"
        else:
            hint = "a subscript is made of letters and digits"
        self._fault(token, "unexpected-character", f"this subscript is no part of a name: {_shown(token.text)}", hint)

    def _superscript(self, sign: _Token, pieces: list[_Piece]) -> None:
        text = "".join(piece.character for piece in pieces[-40:])
        power = _POWER.search(text)
        inner = [piece for piece in self._outside_of_names() if not piece.character.isspace()]
        exponent = "".join(piece.character for piece in inner)
        if power and re.fullmatch(r"[+-]?\d+", exponent):
            start = pieces[len(pieces) - len(power.group())]
            given = pieces[len(pieces) - len(power.group()) :][: len(power.group(1) or "")]
            one = [] if given else [_Piece("1", start.start, start.end)]
            del pieces[len(pieces) - len(power.group()) :]
            pieces += [*given, *one, _Piece("e", sign.start, sign.end), *inner]
            return
        if not inner:
            return
        base = _base(pieces)
        token = _Token("", sign.start, inner[-1].end)
        if base[:1] in ("φ", "π"):
            message = f"{base} has a superscript, but no bar: this is a scheme, not a controller"
            hint = f"name the potential, its transforms and their resources: {_SUPERSCRIPT}"
        elif exponent in ("T", "⊤", "#", "-1", "+", "t"):
            message, hint = "transposed and inverse matrices are of a law, not of a controller", _law_hint(self._text)
        else:
            message = f"there are no powers in a formula, but {base or 'this'} has a superscript"
            hint = f"a superscript stands at a bar, over the effector side: {_SUPERSCRIPT}"
        self._fault(token, "unexpected-superscript", message, hint)

    # --- commands -------------------------------------------------------------------------------------------------

    def _command(self, token: _Token, pieces: list[_Piece]) -> None:
        text = token.text
        if text in _GREEK:
            self._add(pieces, [_Piece(_GREEK[text], token.start, token.end)], atom=True)
        elif text in _SIGNS:
            pieces.append(_Piece(_SIGNS[text], token.start, token.end))
        elif text in _FONTS or text in _TEXTS:
            self._font(text, pieces)
        elif text in _SIZES:
            self._skip_blanks()
            if self._peek() == ".":
                self._next()
        elif text in _DROPPED:
            self._skip_blanks()
            self._raw_group(token)
            pieces.append(_Piece(_WIDE, token.start, token.end))
        elif text in _ABOVE:
            self._argument()
            pieces += self._argument()
        elif text in ("\\begin", "\\end"):
            self._environment(token)
        elif text in _PRODUCTS:
            self._skip_blanks(_SPACES)
            pieces.append(_Piece(" " if self._peek() == "\\sigma" else "×", token.start, token.end))
        elif text in _OF_LAWS:
            self._law(token, text)
        else:
            self._unknown(token)

    def _font(self, command: str, pieces: list[_Piece]) -> None:
        inner = self._argument()
        words = "".join(piece.character for piece in inner).split()
        of_text = command in _TEXTS and any(len(word) > 1 for word in words)
        if _NAME.fullmatch("".join(words)) and (len(words) == 1 or not of_text):
            inner = [piece for piece in inner if not piece.character.isspace()]
            inner[-1] = replace(inner[-1], ends_atom=True)
        self._add(pieces, inner, atom=True)

    def _raw_group(self, command: _Token) -> str:
        """The text in the braces behind a command, as it stands."""
        if self._peek() != "{":
            self._nothing_behind(command)
            return ""
        start = self._next().end
        depth = 1
        while self._peek():
            token = self._next()
            depth += {"{": 1, "}": -1}.get(token.text, 0)
            if depth == 0:
                return self._text[start : token.start]
        self._fault(command, "unbalanced-bracket", "“{” is not closed", "add the missing “}”")
        raise _StopError

    def _environment(self, token: _Token) -> None:
        self._skip_blanks()
        name = self._raw_group(token).strip()
        if name.endswith("matrix") or name in ("array", "cases"):
            self._law(token, name)
        elif name.rstrip("*") in _WITH_COLUMNS and token.text == "\\begin" and self._peek() == "{":
            self._raw_group(token)
        elif name and name not in _ENVIRONMENTS:
            hint = r"put the formula alone between \begin{equation} and \end{equation}"
            self._fault(token, "unknown-command", f"no formula stands in {_shown(name)}", hint)

    def _law(self, token: _Token, sign: str) -> None:
        message = f"{_shown(sign)} is of a law, an equation that says how something is computed, not of a controller"
        self._faults = [Fault(token.start, token.end, "law", message, _law_hint(self._text))]
        raise _StopError

    def _unknown(self, token: _Token) -> None:
        known = [name for name in nearest(token.text, _KNOWN, 2, 0.75) if name != token.text]
        hint = f"did you mean {' or '.join(known)}?" if known else "write a macro of your own as what it stands for"
        what = f"the command {_shown(token.text)}" if len(token.text) > 1 else "a lone backslash"
        self._fault(token, "unknown-command", f"{what} has no meaning in a formula", hint)


def _law_hint(text: str) -> str:
    """The controllers that a law is about, where it names potentials that ◁ joins or takes the gradient of one."""
    joined = re.search(r"\\(?:triangleleft|lhd|vartriangleleft)", text)
    place = joined.start() if joined else 0
    before, after = _POTENTIAL.findall(text[:place]), _POTENTIAL.findall(text[place:])
    names = [before[-1], after[0]] if before and after else after[:1] if "\\nabla" in text else []
    if not names:
        return f"a controller is {_SUPERSCRIPT}, or several of them with \\triangleleft between"
    terms = " ◁ ".join(f"φ_{name}|τ_{name}(Γ) σ_{name}(Γ)" for name in names)
    return f"write the controller that follows it: {terms}"


def _without_number(text: str) -> str:
    """The text without stops at its end, and without an equation's number that stands apart behind it."""
    text = text.rstrip(_STOPS)
    before, bracket, number = text.rpartition("(")
    apart = before.rstrip(" ")[-1:]
    if apart and apart in f"{_WIDE}.,;" and _NUMBER.fullmatch(bracket + number):
        return before.rstrip(_STOPS)
    return text


def _base(pieces: list[_Piece]) -> str:
    """The name that the pieces end with."""
    text = "".join(piece.character for piece in pieces[-40:]).rstrip()
    name = re.search(r"\w+\Z", text)
    return name.group() if name else ""


def _is_letter(character: str) -> bool:
    return character.isalnum() or character == "_"


def _stripped(pieces: list[_Piece]) -> list[_Piece]:
    inked = [place for place, piece in enumerate(pieces) if not piece.character.isspace()]
    return pieces[inked[0] : inked[-1] + 1] if inked else []


def _has_comma(pieces: list[_Piece]) -> bool:
    """Whether pieces are a list: there is a comma outside of all brackets."""
    depth = 0
    for piece in pieces:
        depth += piece.character in "({<"
        depth -= piece.character in ")}>"
        if piece.character == "," and depth == 0:
            return True
    return False


def _as_side(pieces: list[_Piece]) -> list[_Piece]:
    """A side of an abbreviation: several resources are a tuple, with or without brackets around them."""
    if not _has_comma(pieces):
        return pieces
    first, last = pieces[0], pieces[-1]
    return [_Piece("(", first.start, first.start), *pieces, _Piece(")", last.end, last.end)]


def _shown(text: str) -> str:
    return shown(" ".join(text.split()))
