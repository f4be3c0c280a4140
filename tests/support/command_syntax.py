"""Whether a printed `ross` command is one: its subcommands, options and arguments exist and have good values."""

import re
import shlex

import click

from ross_payload.cli import ross

PUNCTUATION = {";", "&", "&&", "|", ">", ">>", "<"}
ASSIGNMENT = re.compile(r"[A-Z_]+=\S*")
AS_ANOTHER_USER = re.compile(r"sudo (-u \S+ )?(-H )?(env )?")
PREFIX = re.compile(r"([^=]*/)?ross")


def ross_commands(line):
    """The arguments of every `ross` in a command line, without what redirects or follows."""
    lexer = shlex.shlex(AS_ANOTHER_USER.sub("", line), posix=True, punctuation_chars=True)
    lexer.whitespace_split = True
    words, found = list(lexer), []
    for place, word in enumerate(words):
        if PREFIX.fullmatch(word) and _is_program(words[:place]):
            rest = words[place + 1 :]
            end = next((i for i, other in enumerate(rest) if other in PUNCTUATION), len(rest))
            found.append(rest[:end])
    return found


def _is_program(before):
    """Whether a word behind these is what runs: the first one, after punctuation or assignments."""
    while before and ASSIGNMENT.fullmatch(before[-1]):
        before = before[:-1]
    return not before or before[-1] in PUNCTUATION


def complaint(arguments):
    """What click says against these arguments; empty when nothing. Nothing is run, and no file need be there."""
    try:
        context = ross.make_context("ross", list(arguments))
        while rest := [*context._protected_args, *context.args] if isinstance(context.command, click.Group) else []:
            name, command, rest = context.command.resolve_command(context, rest)
            context = command.make_context(name, rest, parent=context)
    except click.UsageError as error:
        return error.format_message()
    except click.exceptions.Exit:
        pass
    return ""
