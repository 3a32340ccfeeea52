"""The command line of plant-bench: registers all commands and turns errors into exit codes."""

import sys
from typing import Annotated

import typer

from plant_bench import __version__
from plant_bench.cli.commands.ablate import AblateCommand, ablate_learner_stub
from plant_bench.cli.commands.agents import list_agents
from plant_bench.cli.commands.collect import collect
from plant_bench.cli.commands.compare import compare_runs
from plant_bench.cli.commands.data import data_app
from plant_bench.cli.commands.export import export_run
from plant_bench.cli.commands.hazards import hazards_app
from plant_bench.cli.commands.import_map import import_town
from plant_bench.cli.commands.import_routes import import_routes
from plant_bench.cli.commands.new_agent import new_agent
from plant_bench.cli.commands.replay import replay
from plant_bench.cli.commands.report import report
from plant_bench.cli.commands.rescore import rescore_run
from plant_bench.cli.commands.rfds import score_rfds
from plant_bench.cli.commands.routes import routes_app
from plant_bench.cli.commands.score import score
from plant_bench.cli.commands.serve import serve
from plant_bench.cli.commands.towns import towns_app
from plant_bench.cli.commands.train import train_app
from plant_bench.cli.commands.verify import verify_run
from plant_bench.cli.commands.why import explain_run
from plant_bench.cli.options import EXIT_FAILED, EXIT_INPUT
from plant_bench.errors import InputError, PlantBenchError, in_one_line
from plant_bench.renamed import renamed_option

app = typer.Typer(
    name="plant-bench",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Start with `plant-bench score --agent expert --routes 0 --repetitions 1`.",
)
app.command("score")(score)
app.command("rescore")(rescore_run)
app.command("verify")(verify_run)
app.command("compare")(compare_runs)
app.command("rfds")(score_rfds)
app.command("report")(report)
app.command("replay")(replay)
app.command("why")(explain_run)
app.command("serve")(serve)
app.command("export")(export_run)
app.command("agents")(list_agents)
app.command("new-agent")(new_agent)
app.command("collect")(collect)
app.add_typer(data_app, name="data")
app.add_typer(train_app, name="train")
app.command("ablate", cls=AblateCommand)(ablate_learner_stub)
app.add_typer(towns_app, name="towns")
app.add_typer(routes_app, name="routes")
app.add_typer(hazards_app, name="hazards")
app.command("import")(import_town)
app.command("import-routes")(import_routes)


def _print_version(requested: bool) -> bool:
    if requested:
        typer.echo(f"plant-bench {__version__}")
        raise typer.Exit
    return requested


@app.callback()
def _root(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    """A closed-loop benchmark for driving planners on SUMO: score, compare and train planners.

    `plant-bench COMMAND --help` describes a command. Exit codes: 0 success, 1 a difference or a
    failure, 2 unusable input, 130 stopped with Ctrl-C.
    """


def main() -> None:
    """Run the command line; every `PlantBenchError` is printed as one line, without a traceback."""
    try:
        if message := renamed_option(sys.argv[1:]):
            raise InputError(message)
        app(prog_name="plant-bench")
    except PlantBenchError as error:
        typer.secho(f"plant-bench: {error}", err=True, fg=typer.colors.RED)
        sys.exit(EXIT_INPUT if isinstance(error, InputError) else EXIT_FAILED)
    except BrokenPipeError:  # `plant-bench agents | head -1`
        sys.stderr.close()
        sys.exit(EXIT_FAILED)
    except OSError as error:
        if error.filename is None:
            text = in_one_line(error)
        else:
            text = f"Cannot use {error.filename}: {error.strerror}. Choose another path."
        typer.secho(f"plant-bench: {text}", err=True, fg=typer.colors.RED)
        sys.exit(EXIT_INPUT)
