"""Where the package's source can be mutated, and how: the mutations are Cosmic Ray's.

Cosmic Ray supplies the operators and applies them. Added here are the deletion of a statement and
the choice of places: annotations and decorators are left alone, because most of their mutants
behave the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Example, Operator
from cosmic_ray.operators.provider import OperatorProvider
from parso.python.tree import Keyword

COMPARISONS = (
    *("Eq_NotEq", "NotEq_Eq", "Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt"),
    *("Lt_GtE", "GtE_Lt", "Gt_LtE", "LtE_Gt", "Is_IsNot", "IsNot_Is"),
)
ARITHMETIC = (
    *("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "FloorDiv_Mul", "Mod_Mul"),
    *("BitAnd_BitOr", "BitOr_BitAnd", "BitXor_BitAnd", "LShift_RShift", "RShift_LShift"),
)
NAMES = (
    *(f"ReplaceComparisonOperator_{name}" for name in COMPARISONS),
    *(f"ReplaceBinaryOperator_{name}" for name in ARITHMETIC),
    *("ReplaceUnaryOperator_Delete_Not", "ReplaceUnaryOperator_Delete_USub"),
    *("ReplaceUnaryOperator_Delete_Invert", "ReplaceAndWithOr", "ReplaceOrWithAnd"),
    *("ReplaceTrueWithFalse", "ReplaceFalseWithTrue", "NumberReplacer"),
    *("ReplaceBreakWithContinue", "ReplaceContinueWithBreak", "ZeroIterationForLoop"),
)


class DeleteStatement(Operator):
    """Replaces a call, an augmented assignment or the write of an element by ``pass``.

    The assignment of a local name stays: without it the code fails at once.
    """

    def mutation_positions(self, node: Any) -> Iterator[Any]:
        """See Cosmic Ray."""
        if node.type != "simple_stmt" or not _in_function(node):
            return
        statement = node.children[0]
        if statement.type in ("atom_expr", "power"):
            yield node.start_pos, node.end_pos
        elif statement.type == "expr_stmt":
            target, operator = statement.children[:2]
            if operator.type == "annassign" or (operator == "=" and target.type == "name"):
                return
            yield node.start_pos, node.end_pos

    def mutate(self, node: Any, index: int) -> Any:
        """See Cosmic Ray."""
        statement = node.children[0]
        prefix = statement.get_first_leaf().prefix
        node.children[0] = Keyword("pass", statement.start_pos, prefix)
        return node

    @classmethod
    def examples(cls) -> tuple[Example, ...]:
        """See Cosmic Ray."""
        return (Example("def f(a):\n    a += 1\n", "def f(a):\n    pass\n"),)


PROVIDER = OperatorProvider()
OPERATORS: dict[str, Any] = {
    **{name: PROVIDER[name] for name in NAMES},
    "DeleteStatement": DeleteStatement,
}


@dataclass(frozen=True)
class Mutant:
    """One change in one place.

    Attributes:
        file: relative to the package.
        operator: a name in ``OPERATORS``.
        occurrence: the place, counted through the file.
        line: where it is, from 1.
    """

    file: str
    operator: str
    occurrence: int
    line: int

    @property
    def name(self) -> str:
        """Names the mutant in results."""
        return f"{self.file}:{self.line} {self.operator} {self.occurrence}"

    def source(self, package: Path) -> str:
        """The mutated file's text."""
        text = (package / self.file).read_text(encoding="utf-8")
        mutated = mutate_code(text, OPERATORS[self.operator](), self.occurrence)
        assert mutated is not None, self.name
        return str(mutated)


def mutants_of(package: Path, file: str) -> list[Mutant]:
    """All mutants of a file."""
    nodes = list(ast_nodes(get_ast((package / file).read_text(encoding="utf-8"))))
    found = []
    for name, operator in OPERATORS.items():
        occurrence = 0
        for node in nodes:
            for position in operator().mutation_positions(node):
                if not _left_alone(node):
                    found.append(Mutant(file, name, occurrence, position[0][0]))
                occurrence += 1
    return found


def _in_function(node: Any) -> bool:
    while node is not None and node.type != "funcdef":
        node = node.parent
    return node is not None


def _left_alone(node: Any) -> bool:
    """Whether it is part of an annotation or a decorator, or of a message."""
    child, above = node, node.parent
    while above is not None:
        if above.type in ("decorator", "fstring_expr", "raise_stmt"):
            return True
        # `x: annotation = value` and `def f(x: annotation = value) -> annotation`
        if above.type in ("annassign", "tfpdef") and child is above.children[1]:
            return True
        if above.type == "param" and above.annotation is child:
            return True
        if above.type == "funcdef" and above.annotation is child:
            return True
        child, above = above, above.parent
    return False
