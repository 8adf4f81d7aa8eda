"""The entry point of the command, whose interrupts are owned before anything is imported."""

from .interrupts import own

own()


def main() -> None:
    """The command, of which nothing is to be interrupted once it has ended."""
    from .cli import main as command

    command()


if __name__ == "__main__":
    main()
