"""Commands are made from their verbs: the table says nothing that a verb does not have, and a verb says all."""

import shlex
from inspect import Parameter, signature

import pytest
import typer
from typer.testing import CliRunner

import fric
from fric.cli.command import EXAMPLES, GIVEN, Command, found
from fric.cli.commands import COMMANDS, DESIGN, IDENTIFY, MODELS, SIMULATE
from fric.cli.main import app
from fric.errors import FricError
from fric.verb import VerbForm

RUN = CliRunner()
MADE = {
    name: one
    for part in (COMMANDS, {f"identify {name}": one for name, one in IDENTIFY.items()}, DESIGN, SIMULATE)
    for name, one in part.items()
    if isinstance(one, Command)
}


@pytest.mark.parametrize("name", MADE)
def test_a_table_entry_fits_its_verb(name):
    command = MADE[name]
    names = {*command.form.names, *(one for more in command.further.values() for one in more)}
    named = {*command.flags, *command.helps, *command.places, *command.options, *command.without, *command.bound}
    assert named <= names
    forms = [(command.form, command.form.names), *((VerbForm(verb), more) for verb, more in command.further.items())]
    inner = {*GIVEN, *command.without, *command.bound}
    helps = {one: form[one].help for form, ones in forms for one in ones if one not in inner}
    assert {one for one, text in helps.items() if not text} == set()


@pytest.mark.parametrize("name", MADE)
def test_the_source_of_a_verb_says_what_python_sees(name):
    """A form is read from the source alone; here the verb is imported, too."""
    form = VerbForm(MADE[name].verb)
    verb = found(MADE[name].verb)
    seen = signature(verb.__wrapped__).parameters
    assert form.names == list(seen)
    for one in set(form.names) - GIVEN - {*MADE[name].without}:
        assert form[one].default == seen[one].default
        hint = seen[one].annotation
        assert form[one].hint == (eval(hint, verb.__wrapped__.__globals__) if isinstance(hint, str) else hint)
        assert form[one].several == (seen[one].kind is Parameter.VAR_POSITIONAL)


@pytest.mark.parametrize(("call", "words"), [
    (lambda: fric.identify_model("lugre", "x.h5", seed=-1), "takes seed as .* from 0 to 4294967295.* given -1"),
    (lambda: fric.identify_plant("x.h5", coherence=1.5), "takes coherence as a number from 0 to 1.* given 1.5"),
    (lambda: fric.circle("xy-table", machines=0), "takes machines as a whole number from 1 to 100000.* given 0"),
    (lambda: fric.compare("x.h5", blocks=0), "takes blocks as a whole number from 1 to 12, and was given 0"),
])  # fmt: skip
def test_python_refuses_numbers_out_of_bounds_too(call, words):
    with pytest.raises(FricError, match=words):
        call()


def test_a_lead_is_a_text_with_its_unit_too():
    told = [fric.read_machine("xy-table", lead=lead).axis("x").nominal_friction.lead for lead in ("0.6 ms", 0.0006)]
    assert told == [pytest.approx(6e-4)] * 2
    assert fric.read_machine("xy-table", lead="auto").axis("x").nominal_friction.lead == "auto"


@pytest.mark.parametrize(("words", "told"), [
    (["--lead", "-1 ms"], "lead of the feedforward is -0.001 s"),
    (["--lead", "1 h"], "lead of the feedforward is 3600 s"),
    (["--gain", "nan"], "gain of the feedforward is nan"),
    (["--gain", "-1"], "gain of the feedforward is -1"),
    (["--gain", "20"], "gain of the feedforward is 20"),
])  # fmt: skip
def test_a_feedforward_that_is_none_ends_in_a_sentence(words, told):
    """A negative lead ended in a traceback, and a gain that is no number in the error of a circle."""
    error = CliRunner().invoke(app, ["simulate", "circle", "xy-table", "--scheme", "c", *words]).exception
    assert isinstance(error, FricError)
    assert told in error.what


@pytest.mark.parametrize("period", ["1e-12 s", "1 h"])
def test_a_period_that_no_record_holds_twice_is_told(period, tmp_path):
    """One below a sample ended in a division by zero."""
    words = ["identify", "plant", "data/frequency-response.h5", "-o", str(tmp_path / "plant.yaml"), "--period", period]
    error = CliRunner().invoke(app, words).exception
    assert isinstance(error, FricError)
    assert "the right --period" in error.hint


def test_a_controller_of_no_rate_is_told(tmp_path):
    words = ["identify", "plant", "data/frequency-response.h5", "-o", str(tmp_path / "plant.yaml")]
    assert CliRunner().invoke(app, words).exit_code == 0
    error = CliRunner().invoke(app, ["design", "controller", words[-1], "--sampling", "0 Hz"]).exception
    assert isinstance(error, FricError)
    assert error.what == "'0 Hz' is not positive"


def test_a_path_of_a_wrong_type_ends_in_a_sentence():
    with pytest.raises(FricError, match="path takes points as points, or their file, and was given an int"):
        fric.path("xy-table", 3)


@pytest.mark.parametrize(("name", "text", "words"), [
    ("identify static", "use `direction='both'`.", "use --direction both."),
    ("identify static", "leave `over_position=` out", "leave --over-position out"),
    ("diagnose", "as in `feed='100 mm/s'`", "as in --feed '100 mm/s'"),
    ("export", "`force=True`, `drawn=`, `single=`", "--force, --run, --float"),
    ("circle", "`nominal_files='x=FRICTION.yaml'`", "--friction x=FRICTION.yaml"),
    ("controller", "`K_p=`", "--K_p"),
    ("plan", "`fric plan --friction` says", "`fric plan --friction` says"),
])  # fmt: skip
def test_errors_name_options_on_the_line_and_arguments_in_python(name, text, words):
    assert MADE[name].worded(text) == words


def test_an_output_that_exists_is_replaced_as_the_interface_says(tmp_path):
    made = tmp_path / "log.h5"
    words = ["simulate", "experiment", "xy-table", "--kind", "sliding-sine", "--samples", "200", "-o", str(made)]
    assert CliRunner().invoke(app, words).exit_code == 0
    assert CliRunner().invoke(app, words).exception.hint.endswith("replace it with --force.")
    with pytest.raises(FricError, match=r"replace it with `force=True`\."):
        fric.read(made).save(made)


def commands(group, names=()):
    """Every command with its words, groups left out."""
    for name in group.list_commands(None):
        found = group.get_command(None, name)
        if hasattr(found, "list_commands"):
            yield from commands(found, (*names, name))
        else:
            yield " ".join((*names, name)), found


ALL = dict(commands(typer.main.get_command(app)))


@pytest.mark.parametrize("name", ALL)
def test_help_shows_an_example_and_cuts_no_line(name):
    shown = RUN.invoke(app, [*name.split(), "-h"]).output
    assert "..." not in shown
    assert all(len(line) <= 80 for line in shown.splitlines())
    lines = EXAMPLES.get(name, ())
    assert lines or name.removeprefix("identify ") in MODELS
    for line in lines:
        assert f"  fric {line}\n" in shown.replace(" \\\n     ", "")
        words = shlex.split(line)
        assert line.startswith(name)
        known = {option for one in ALL[name].params for option in (*one.opts, *one.secondary_opts)}
        assert {word for word in words if word.startswith("-")} <= known


def test_commands_are_listed_by_the_order_of_the_work_and_help_of_one_is_shown():
    listed = RUN.invoke(app, ["-h"]).output.partition("\n\n")[2]
    assert "..." not in listed
    places = [listed.index(f"\n  {name} ") for name in ("auto", "ingest", "identify", "export")]
    assert places == sorted(places)
    for topic in ("tune", "identify gms"):
        shown = RUN.invoke(app, ["help", *topic.split()])
        assert shown.exit_code == 0
        assert shown.output.startswith(f"Usage: fric {topic} ")


def test_help_shows_the_types_alone():
    """What fric checks of an argument, ``Annotated[ForwardRef(…), Kind(read=…)]``, made `help` hard to read."""
    shown = str(signature(fric.identify_static))
    assert shown.startswith("(*logs: Record | Path | str | Iterable[Record | Path | str], plant: Plant | PlantDoc")
    assert "load: float | str | None = None" in shown
    for name in fric.__all__:
        if hasattr(verb := getattr(fric, name), "__wrapped__"):
            assert not {word for word in ("Annotated", "Kind(", "ForwardRef") if word in str(signature(verb))}


def test_the_feed_of_a_simulation_is_named_as_elsewhere():
    """`fric plan`, `ingest` and `diagnose` have --feed; here it was unknown, and --lead or --seed were proposed."""
    done = [
        CliRunner().invoke(
            app, ["simulate", "circle", "xy-table", "--scheme", "a", "--revolutions", "1", name, "50 mm/s"]
        )
        for name in ("--velocity", "--feed")
    ]
    assert [one.exit_code for one in done] == [0, 0]
    assert done[0].stdout == done[1].stdout
    assert "50 mm/s" in done[1].stdout
