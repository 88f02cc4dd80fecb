"""The stubs say what the module has, and every part of it is documented."""
import ast
import inspect
import unittest

import taut
from support import SOURCE

STUBS = ast.parse((SOURCE / "render/python/taut.pyi").read_text())


def public(scope):
    return {name for name in vars(scope) if not name.startswith("_")}


def stubbed(body):
    """Names of the definitions in a body of the stubs, with their nodes; annotated names are values."""
    nodes = {node.name: node for node in body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    return nodes | {node.target.id: node for node in body if isinstance(node, ast.AnnAssign)}


def parameters(arguments):
    """Names with their kinds and defaults, without self."""
    all_defaults = [None] * (len(arguments.args) - len(arguments.defaults)) + arguments.defaults
    positional = [(a.arg, "positional", d) for a, d in zip(arguments.args, all_defaults)]
    keyword = [(a.arg, "keyword", d) for a, d in zip(arguments.kwonlyargs, arguments.kw_defaults)]
    more = [("**", "keywords", None)] if arguments.kwarg else []
    return [(name, kind, d and ast.unparse(d)) for name, kind, d in positional + keyword + more if name != "self"]


def signature(function):
    """As pybind11 writes it into the first line of the docstring; types as it has them are dropped."""
    line = function.__doc__.splitlines()[0]
    names = line.replace("taut.", "").replace("::", ".")
    return parameters(ast.parse(f"def {names}: ...").body[0].args)


class Stubs(unittest.TestCase):
    def test_have_the_module_s_names(self):
        nodes = stubbed(STUBS.body)
        self.assertEqual({name for name in nodes if not name.startswith("__")}, public(taut))
        for name, node in nodes.items():
            found = getattr(taut, name)
            if isinstance(node, ast.ClassDef):
                bases = {getattr(base, "id", None) for base in node.bases} or {"object", "pybind11_object"}
                self.assertLessEqual({base.__name__ for base in found.__bases__}, bases | {"pybind11_object"}, name)
                self.check_members(found, node)
            elif isinstance(node, ast.FunctionDef):
                self.check_function(found, node, name)

    def check_members(self, found, node):
        if issubclass(found, Exception):
            return  # their attributes are set when they are raised
        nodes = stubbed(node.body)
        members = public(found) | ({"__init__"} if "__init__" in nodes else set())
        self.assertEqual(set(nodes), members, node.name)
        for name, member in nodes.items():
            what = f"{node.name}.{name}"
            is_property = [getattr(d, "id", "") for d in member.decorator_list] == ["property"]
            self.assertEqual(is_property, isinstance(vars(found)[name], property), what)
            if is_property:
                self.assertTrue(vars(found)[name].__doc__, what)
            else:
                self.check_function(getattr(found, name), member, what)

    def check_function(self, found, node, what):
        self.assertEqual(signature(found), parameters(node.args), what)
        if node.name != "__init__":
            self.assertTrue(found.__doc__.split("\n", 1)[1].strip(), f"{what} has no docstring")

    def test_everything_has_a_docstring(self):
        self.assertTrue(inspect.getdoc(taut))
        for name in public(taut):
            self.assertTrue(inspect.getdoc(getattr(taut, name)), name)


if __name__ == "__main__":
    unittest.main()
