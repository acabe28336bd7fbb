"""One function of the typed tree in C: its statements and expressions."""

import functools
from typing import TYPE_CHECKING, Any

from vibrocap.numerics.compiler.kinds import BOOL, ELEMENTS, FLOAT, INT, NOTHING, Kind
from vibrocap.numerics.compiler.subset import Refused
from vibrocap.numerics.compiler.typed import nodes

if TYPE_CHECKING:
    from vibrocap.numerics.compiler.c_text import Module

SIGNS = {"Add": "+", "Sub": "-", "Mult": "*", "Div": "/", "BitAnd": "&", "BitOr": "|", "BitXor": "^"}
WRAPPED = {"Add": "add", "Sub": "sub", "Mult": "mul", "LShift": "shl", "RShift": "shr"}
WRAPPED |= {"FloorDiv": "floor_divided", "Mod": "floor_rest"}
COMPARED = {"Lt": "<", "LtE": "<=", "Gt": ">", "GtE": ">=", "Eq": "==", "NotEq": "!="}
OF_MATH = ("floor", "sqrt")


class CFunction:
    """One function: each value is a C expression without effects, evaluated where it stands in Python.

    What an effect could change (entries of arrays) or what is read again becomes a variable at once.
    """

    def __init__(self, module: "Module", function: nodes.Function):
        self.module, self.function = module, function
        self.lines: list[str] = []
        self.declared: list[str] = []
        self.known: dict[Any, str] = {}
        self.count = 0
        self.depth = 1
        self.counters: list[tuple[str, str]] = []

    def written(self) -> str:
        """The lines between its braces."""
        self._block(self.function.body)
        own = [f"  {self.module.type(kind)} v_{name};" for name, kind in self.function.variables.items()]
        return "\n".join([*own, *self.declared, *self.lines])

    def do(self, code: str) -> None:
        """A statement."""
        self.lines.append("  " * self.depth + code)

    def place(self, kind: Kind) -> str:
        """A new variable."""
        self.count += 1
        self.declared.append(f"  {self.module.type(kind)} t{self.count};")
        return f"t{self.count}"

    def held(self, kind: Kind, text: str) -> str:
        """A value in a variable of its own."""
        name = self.place(kind)
        self.do(f"{name} = {text};")
        return name

    def value(self, node: nodes.Typed) -> str:
        """An expression, after statements that its parts need."""
        return getattr(self, nodes.WRITERS[type(node)])(node)

    def of_kind(self, node: nodes.Typed, kind: Kind) -> str:
        """A value as one of another kind that can hold it."""
        return self._as(self.value(node), node.kind, kind)

    def _as(self, text: str, own: Kind, kind: Kind) -> str:
        if own is kind:
            return text
        if kind.items:
            items = [self._as(f"{text}.i{i}", a, b) for i, (a, b) in enumerate(zip(own.items, kind.items, strict=True))]
            return self._packed(kind, items)
        return f"(({self.module.type(kind)}){text})"

    def _packed(self, kind: Kind, items: list[str]) -> str:
        name = self.place(kind)
        for i, item in enumerate(items):
            self.do(f"{name}.i{i} = {item};")
        return name

    # --- values ------------------------------------------------------------------------------------------------------

    def _of_Number(self, node: nodes.Number) -> str:
        return number_text(node.constant)

    def _of_Argument(self, node: nodes.Argument) -> str:
        return f"a_{node.name}"

    def _of_Variable(self, node: nodes.Variable) -> str:
        return f"v_{node.name}"

    def _again(self, node: nodes.Typed) -> str:
        return self.known[node]

    _of_Let = _of_Counter = _of_Held = _again

    def _of_Shared(self, node: nodes.Shared) -> str:
        if node not in self.known:
            self.known[node] = self.held(node.kind, self.value(node.value))
        return self.known[node]

    def _of_Tuple(self, node: nodes.Tuple) -> str:
        return self._packed(node.kind, [self.value(item) for item in node.items])

    def _of_Item(self, node: nodes.Item) -> str:
        return f"{self.value(node.base)}.i{node.place}"

    def _of_Entry(self, node: nodes.Entry) -> str:
        return self.held(node.kind, f"{self.value(node.array)}[{self.value(node.place)}]")

    def _of_TableEntry(self, node: nodes.TableEntry) -> str:
        name = self.module.table(f"table_{node.table.name}", node.table.constant.ravel().tolist())
        places = [self.value(place) for place in node.places]
        at = places[0] if len(places) == 1 else f"{places[0]} * {node.table.constant.shape[1]} + {places[1]}"
        return f"{name}[{at}]"

    def _of_Chosen(self, node: nodes.Chosen) -> str:
        numbers = [float(x) if node.kind is FLOAT else int(x) for x in node.base.constant]
        spelled = "".join(c if c.isalnum() else "_" for c in repr(node.base.constant))
        return f"{self.module.table(f'tuple{spelled}', numbers)}[{self.value(node.place)}]"

    def _of_Converted(self, node: nodes.Converted) -> str:
        return self.of_kind(node.value, node.kind)

    def _of_Truncated(self, node: nodes.Truncated) -> str:
        return f"{self.module.helper('truncated')}({self.value(node.value)})"

    def _of_Viewed(self, node: nodes.Viewed) -> str:
        name = "bits" if node.kind is INT else "float_of"
        return f"{self.module.helper(name)}({self.value(node.value)})"

    def _of_Truth(self, node: nodes.Truth) -> str:
        return f"({self.value(node.value)} != 0)"

    def _of_Binary(self, node: nodes.Binary) -> str:
        kind, op = node.operands, node.operator
        left = self.of_kind(node.left, kind)
        right = self.of_kind(node.right, kind)
        if kind is INT and op in WRAPPED:
            return f"{self.module.helper(WRAPPED[op])}({left}, {right})"
        return f"({left} {SIGNS[op]} {right})"

    def _of_FloatPower(self, node: nodes.FloatPower) -> str:
        raise Refused("this kernel has no polynomials for `pow`")

    def _of_Power(self, node: nodes.Power) -> str:
        exponent = node.exponent.constant
        base = self.value(node.base)
        kind, left, power = node.base.kind, abs(exponent), ""
        times = f"{self.module.helper('mul')}({{}}, {{}})" if kind is INT else "({} * {})"
        base = self.held(kind, base)
        while left != 0:  # in this order to the last bit; 1 times a number is that number
            if left & 1:
                power = times.format(power, base) if power else base
            left >>= 1
            if left:
                base = self.held(kind, times.format(base, base))
        power = power or ("INT64_C(1)" if kind is INT else "1.0")
        return power if exponent >= 0 else f"(1.0 / {power})"

    def _of_Unary(self, node: nodes.Unary) -> str:
        value = self.value(node.value)
        if node.operator == "USub":
            return f"(-{value})" if node.kind is FLOAT else f"{self.module.helper('sub')}(0, {value})"
        return f"(!{value})" if node.operator == "Not" else f"(~{value})"

    def _of_Compared(self, node: nodes.Compared) -> str:
        left = self.of_kind(node.left, node.operands)
        return f"({left} {COMPARED[node.operator]} {self.of_kind(node.right, node.operands)})"

    def _of_Within(self, node: nodes.Within) -> str:
        return f"({' | '.join([self.value(part) for part in node.parts])})"

    def _of_Junction(self, node: nodes.Junction) -> str:
        name, depth = self.place(BOOL), self.depth
        for i, part in enumerate(node.parts):
            if i:
                self.do(f"if ({'' if node.all_of else '!'}{name}) {{")
                self.depth += 1
            self.do(f"{name} = {self.value(part)};")
        while self.depth > depth:
            self.depth -= 1
            self.do("}")
        return name

    def _of_Choice(self, node: nodes.Choice) -> str:
        condition, name = _in_brackets(self.value(node.condition)), self.place(node.kind)
        for head, part in ((f"if {condition} {{", node.one), ("} else {", node.other)):
            self.do(head)
            self.depth += 1
            self.do(f"{name} = {self.of_kind(part, node.kind)};")
            self.depth -= 1
        self.do("}")
        return name

    def _of_Extreme(self, node: nodes.Extreme) -> str:
        sign = COMPARED[node.operator]

        def better(one: str, other: str) -> str:
            other = self.held(node.kind, other)
            return self.held(node.kind, f"{other} {sign} {one} ? {other} : {one}")

        first, *rest = [self.of_kind(part, node.kind) for part in node.parts]
        return functools.reduce(better, rest, self.held(node.kind, first))

    def _of_Magnitude(self, node: nodes.Magnitude) -> str:
        name = "fabs" if node.kind is FLOAT else self.module.helper("magnitude")
        return f"{name}({self.value(node.value)})"

    def _of_Library(self, node: nodes.Library) -> str:
        if node.function not in OF_MATH:
            raise Refused(f"this kernel has no polynomials for `{node.function}`")
        return f"{node.function}({self.value(node.value)})"

    def _of_Call(self, node: nodes.Call) -> str:
        pairs = zip(node.arguments, node.function.arguments, strict=True)
        passed = [self.of_kind(argument, kind) for argument, (_, kind) in pairs]
        called = f"{self.module.written(node.function)}({', '.join(passed)})"
        if node.kind is not NOTHING:
            return self.held(node.kind, called)
        self.do(f"{called};")
        return ""

    def _of_Primitive(self, node: nodes.Primitive) -> str:
        raise Refused(f"C has no `{node.name}` of lanes; write the kernel for one lane")

    # --- statements --------------------------------------------------------------------------------------------------

    def _block(self, statements: Any) -> None:
        for statement in statements:
            getattr(self, f"_do_{type(statement).__name__}")(statement)

    def _inner(self, statements: Any) -> None:
        self.depth += 1
        self._block(statements)
        self.depth -= 1

    def _do_Evaluate(self, node: nodes.Evaluate) -> None:
        self.value(node.value)

    def _do_Bind(self, node: nodes.Bind) -> None:
        self.known[node.let] = self.held(node.let.kind, self.value(node.let.value))

    def _do_Assign(self, node: nodes.Assign) -> None:
        self.do(f"v_{node.name} = {self.of_kind(node.value, node.kind)};")

    def _do_Unpack(self, node: nodes.Unpack) -> None:
        self._hold(node.items, node.value.kind, self.value(node.value))
        self._block(node.statements)

    def _hold(self, held: tuple[nodes.Typed, ...], kind: Kind, text: str) -> None:
        for i, (place, item) in enumerate(zip(held, kind.items, strict=True)):
            if isinstance(place, nodes.Held):
                self.known[place] = self.held(item, f"{text}.i{i}")
            elif isinstance(place, nodes.Tuple) and place.constant is None:
                self._hold(place.items, item, f"{text}.i{i}")

    def _do_Store(self, node: nodes.Store) -> None:
        value = self.of_kind(node.value, ELEMENTS[node.array.kind])
        self.do(f"{self.value(node.array)}[{self.value(node.place)}] = {value};")

    def _do_Augment(self, node: nodes.Augment) -> None:
        place = self.held(INT, self.value(node.place))
        array = self.value(node.array)
        self.known[node.held] = self.held(node.held.kind, f"{array}[{place}]")
        self.do(f"{array}[{place}] = {self.of_kind(node.value, node.held.kind)};")

    def _do_If(self, node: nodes.If) -> None:
        self.do(f"if {_in_brackets(self.value(node.condition))} {{")
        self._inner(node.body)
        if node.orelse:
            self.do("} else {")
            self._inner(node.orelse)
        self.do("}")

    def _do_While(self, node: nodes.While) -> None:
        self.do("for (;;) {")
        self.depth += 1
        if node.condition.constant is None:
            self.do(f"if (!({self.value(node.condition)})) break;")
        self._block(node.body)
        self.depth -= 1
        self.do("}")

    def _do_For(self, node: nodes.For) -> None:
        first = self.value(node.first)
        last = self.held(INT, self.value(node.last))
        counter = self.known[node.counter] = self.place(INT)
        sign = "<" if node.step > 0 else ">"
        self.do(f"for ({counter} = {first}; {counter} {sign} {last}; {counter} += {node.step}) {{")
        self._inner(node.body)
        self.do("}")

    def _do_Break(self, node: nodes.Break) -> None:
        self.do("break;")

    def _do_Continue(self, node: nodes.Continue) -> None:
        self.do("continue;")

    def _do_Return(self, node: nodes.Return) -> None:
        self.do("return;" if node.value is None else f"return {self.of_kind(node.value, self.function.result)};")


def _in_brackets(text: str) -> str:
    """A condition in one pair of brackets: compilers warn of an equality in two, as if an assignment had been meant."""
    depth = 0
    for place, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0:
            return text if letter == ")" and place == len(text) - 1 else f"({text})"
    return f"({text})"


def number_text(number: bool | int | float) -> str:
    """All bits of a number, as C reads them."""
    if isinstance(number, bool):
        return str(int(number))
    if isinstance(number, int):
        if number == -(2**63):
            return "INT64_MIN"
        return f"INT64_C({number})" if number >= 0 else f"(-INT64_C({-number}))"
    if number != number:
        return "NAN"
    if number in (float("inf"), float("-inf")):
        return "INFINITY" if number > 0 else "(-INFINITY)"
    return number.hex() if not number.hex().startswith("-") else f"({number.hex()})"
