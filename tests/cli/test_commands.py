"""Commands are made from their verbs: the table says nothing that a verb does not have, and a verb says all."""

from inspect import Parameter, signature

import pytest

import fric
from fric.cli.command import GIVEN, Command, found
from fric.cli.commands import COMMANDS, DESIGN, IDENTIFY, SIMULATE
from fric.errors import FricError
from fric.verb import Form

MADE = {
    name: one
    for part in (COMMANDS, DESIGN, IDENTIFY, SIMULATE)
    for name, one in part.items()
    if isinstance(one, Command)
}


@pytest.mark.parametrize("name", MADE)
def test_a_table_entry_fits_its_verb(name):
    command = MADE[name]
    names = {*command.form.names, *(one for more in command.further.values() for one in more)}
    named = {*command.flags, *command.helps, *command.places, *command.options, *command.without, *command.bound}
    assert named <= names
    forms = [(command.form, command.form.names), *((Form(verb), more) for verb, more in command.further.items())]
    inner = {*GIVEN, *command.without, *command.bound}
    helps = {one: form[one].help for form, ones in forms for one in ones if one not in inner}
    assert {one for one, text in helps.items() if not text} == set()


@pytest.mark.parametrize("name", MADE)
def test_the_source_of_a_verb_says_what_python_sees(name):
    """A form is read from the source alone; here the verb is imported, too."""
    form = Form(MADE[name].verb)
    verb = found(MADE[name].verb)
    seen = signature(verb).parameters
    assert form.names == list(seen)
    for one in set(form.names) - GIVEN - {*MADE[name].without}:
        assert form[one].default == seen[one].default
        hint = seen[one].annotation
        assert form[one].hint == (eval(hint, verb.__wrapped__.__globals__) if isinstance(hint, str) else hint)
        assert form[one].several == (seen[one].kind is Parameter.VAR_POSITIONAL)


@pytest.mark.parametrize(("call", "words"), [
    (lambda: fric.identify_model("lugre", "x.h5", seed=-1), "takes seed as a whole number of at least 0.* given -1"),
    (lambda: fric.identify_plant("x.h5", coherence=1.5), "takes coherence as a number from 0 to 1.* given 1.5"),
    (lambda: fric.circle("xy-table", machines=0), "takes machines as a whole number of at least 1.* given 0"),
    (lambda: fric.compare("x.h5", blocks=0), "takes blocks as a whole number of at least 1.* given 0"),
])  # fmt: skip
def test_python_refuses_numbers_out_of_bounds_too(call, words):
    with pytest.raises(FricError, match=words):
        call()


def test_a_lead_is_a_text_with_its_unit_too():
    told = [fric.read_machine("xy-table", lead=lead).axis("x").nominal_friction.lead for lead in ("0.6 ms", 0.0006)]
    assert told == [pytest.approx(6e-4)] * 2
    assert fric.read_machine("xy-table", lead="auto").axis("x").nominal_friction.lead == "auto"


def test_a_path_of_a_wrong_type_ends_in_a_sentence():
    with pytest.raises(FricError, match="path takes points, or their file, and was given an int"):
        fric.path("xy-table", 3)
