"""The report of a run, as JSON and as text."""

OUTCOMES = ("killed", "equivalent", "survived", "not built")


def entries(mutants, outcomes):
    return [{"room": m.room, "file": m.file, "line": m.line, "operator": m.operator,
             "source line": m.source_line, "change": m.change, **outcomes[m.number]}
            for m in mutants]


def text(mutants):
    """A table of the rooms, and the survivors."""
    rooms = dict.fromkeys(m["room"] for m in mutants)
    rows = [row(room, [m for m in mutants if m["room"] == room]) for room in rooms]
    lines = ["| room | mutants | killed | equivalent | survived | not built | killed of the others |",
             "|---|--:|--:|--:|--:|--:|--:|", *rows, row("all", mutants)]
    for m in mutants:
        if m["outcome"] == "survived":
            reached = f"{m['tests run']} of {m['reached by']} tests that reach it"
            lines.append(f"\n{m['file']}:{m['line']}: {m['operator']}\n  {m['change']}\n  passed by "
                         f"{reached if m['reached by'] else 'all: no test reaches it'}")
    return "\n".join(lines)


def row(name, mutants):
    counts = [sum(m["outcome"] == outcome for m in mutants) for outcome in OUTCOMES]
    killed, _, survived, _ = counts
    share = f"{100 * killed / (killed + survived):.0f} %" if killed + survived else ""
    return f"| {name} | {len(mutants)} | " + " | ".join(map(str, counts)) + f" | {share} |"
