"""Tables in Markdown, written and read."""


def markdown(rows, numbers=()):
    """A table; columns in `numbers` stand on the right."""
    rule = ["---:" if i in numbers else "---" for i in range(len(rows[0]))]
    lines = ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "|".join(rule) + "|", *lines[1:]])


def digits(value, count):
    """With so many digits that count, and never as a power of ten."""
    rounded = float(f"{value:.{count}g}")
    return f"{rounded:.0f}" if rounded >= 10 ** (count - 1) else f"{rounded:g}"


def first_table(text):
    return text.split("\n\n")[0]


def cells(text):
    """The rows of the first table of a text in Markdown, the header among them."""
    lines = first_table(text).splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[:1] + lines[2:]]
