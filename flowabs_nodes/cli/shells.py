"""Teaches click's completion in bash, zsh and fish about ``name=value``.

bash splits words at "=" before it asks for completions, and replaces only what stands behind it. bash and zsh add a
space behind each completion, also behind ``line_width=``, where a value has to follow. In fish, click ends a help text
at its first comma. Where another version of click has another script, that script is used as it is.
"""

from __future__ import annotations

import os

from click.shell_completion import BashComplete, CompletionItem, FishComplete, ZshComplete, add_completion_class

#: The variable by which a shell asks for completions, as click names it.
VARIABLE = "_FLOWABS_COMPLETE"


class Bash(BashComplete):
    """Completes ``--set name=value`` in bash."""

    source_template = BashComplete.source_template.replace(
        "COMPREPLY+=($value)\n", "COMPREPLY+=($value)\n            [[ $value == *[=./] ]] && compopt -o nospace\n"
    )
    _done = ""  # what stands before the last "=" in the word: bash leaves it as it is

    def get_completion_args(self) -> tuple[list[str], str]:
        """Return the complete words and the one to complete, put together again at "="."""
        args, incomplete = super().get_completion_args()
        words: list[str] = []
        for word in (*args, *([incomplete] if incomplete else ())):
            if words and (word == "=" or words[-1].endswith("=")):
                words[-1] += word
            else:
                words.append(word)
        incomplete = words.pop() if incomplete else ""
        self._done = incomplete[: incomplete.rfind("=") + 1]
        return words, incomplete

    def format_completion(self, item: CompletionItem[str]) -> str:
        """Return a line of the answer: the item's type, and of its value what bash replaces."""
        return f"{item.type},{item.value.removeprefix(self._done)}"


class Zsh(ZshComplete):
    """Completes ``--set name=value`` in zsh."""

    source_template = (
        ZshComplete.source_template.replace("    local -a response\n", "    local -a response\n    local -a open\n")
        .replace(
            '            if [[ "$descr" == "_" ]]; then\n',
            '            if [[ "$key" == *[=./] ]]; then\n                open+=("$key":"$descr")\n'
            '            elif [[ "$descr" == "_" ]]; then\n',
        )
        .replace(
            '    if [ -n "$completions" ]; then\n',
            '    if [ -n "$open" ]; then\n        _describe -V unsorted open -U -S ""\n    fi\n\n'
            '    if [ -n "$completions" ]; then\n',
        )
    )


class Fish(FishComplete):
    """Completes in fish, with whole help texts."""

    source_template = FishComplete.source_template.replace('string split "," ', 'string split --max 1 "," ')


def register() -> None:
    """Let click use these classes where a shell asks this process for completions; do nothing in any other."""
    if VARIABLE in os.environ:
        for shell in (Bash, Zsh, Fish):
            add_completion_class(shell)
