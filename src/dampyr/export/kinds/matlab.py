"""MATLAB: one function file, which GNU Octave runs too."""

from __future__ import annotations

from pathlib import Path
from textwrap import wrap

from dampyr.atomic_write import write_whole
from dampyr.errors import InputError
from dampyr.export.kinds.c import ARRAYS, WIDTH, before_use, check_exportable, check_name, function_trees
from dampyr.export.matlab_text import SUPPORT, function, number
from dampyr.input_kinds import INPUTS
from dampyr.models import Constant, Damper, Interpolation, Polynomial
from dampyr.models.laws import Law
from dampyr.source_digest import full_version


def write(damper: Damper, folder: Path, name: str, allow_extrapolation: bool = False) -> list[Path]:
    """Write ``name.m``; ``help name`` says how it is called."""
    check_name(name)
    check_exportable(damper)
    prefix = f"{name}_"
    formulas, whole = function_trees(damper)
    names = {tree.name for tree in (*formulas, *whole)}
    texts = [_main(damper, name, allow_extrapolation), _parameters(damper, prefix)]
    texts += [function(tree, prefix, names) for tree in formulas]
    texts += [function(tree, prefix, names, ARRAYS) for tree in whole]
    texts += [SUPPORT.replace("{prefix}", prefix).strip()]
    if damper.composition.has_delay:
        texts += [_late(prefix)]
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.m"
    write_whole(path, "\n\n".join(texts) + "\n")
    return [path]


def _main(damper: Damper, name: str, allow_extrapolation: bool) -> str:
    composition, prefix = damper.composition, f"{name}_"
    low, high = damper.range
    slack = 1e-9 * max(abs(low), abs(high), 1.0)
    outside = f"u < {number(low - slack)} | u > {number(high + slack)} | isnan(u)"
    bad = "~isfinite(u)" if allow_extrapolation else outside
    given, numbers, u_of_sample = ["t", "x", "v"], "", ""
    about, check, followed, kept = ".", "", "", ""
    if damper.has_input:
        word, unit = INPUTS[damper.input], damper.input
        given, u_of_sample = ["t", "x", "v", "u"], "u(k)"
        about = f"; u is the {word} [{unit}] at the coil, one number or one for each sample."
        if damper.input_lag:
            about = (
                f"; u is the command of the {word} [{unit}]; the coil follows it, time constant {damper.input_lag:g} s."
            )
            u_of_sample = "acting"
            followed, kept = _follow(damper.input_lag), "\n        state.command = u(k); state.acting = acting;"
        numbers = "\n    if isscalar(u), u = repmat(u, size(x)); end"
        check = f"""
    bad = find({bad}, 1);
    if ~isempty(bad)
        error('{name}:range', '{word} = %g {unit} at sample %d; calibrated from {low:g} to {high:g} {unit}', u(bad), bad);
    end"""
    arguments, sizes = ", ".join(given), ", ".join(f"numel({key})" for key in given)
    listed = f"{', '.join(given[:-1])} and {given[-1]} have {', '.join(['%d'] * (len(given) - 1))} and %d samples"
    start = ", ".join(number(value) for value in composition.path0) or "0.0"
    warned = "".join(f"\n%   {line}" for line in wrap(before_use(damper), WIDTH))
    late = composition.delay is not None
    delayed = f"\n        [f(k), state] = {prefix}late(state, f(k), p({(composition.delay or 0) + 1}));" if late else ""
    empty = "\n        state.late_t = []; state.late_f = [];" if late else ""
    origin = f"\n%   {notice}." if (notice := damper.origin.notice) else ""
    return f"""\
function [f, state] = {name}({arguments}, state)
%{name.upper()}  Force of a damper along a path.
%   f = {name}({arguments}) is the force [N] at the times t [s] of a path with the displacement x [m] and the velocity
%   v [m/s]{about} A positive force opposes a positive
%   velocity. The path begins at rest.
%   [f, state] = {name}({arguments}, state) goes on from the state that an earlier call returned, with later samples.
%
%   The model: {composition}. The damper {damper.range_words}. Written by dampyr {full_version()}.{origin}{warned}
    if nargin < {len(given) + 1}, state = []; end{numbers}
    if ~isequal({sizes})
        error('{name}:size', '{listed}; give as many of each', ...
            {sizes});
    end{check}
    f = zeros(size(x));
    for k = 1:numel(t){followed}
        p = {prefix}parameters({u_of_sample});
        if isempty(state)
            state = struct('s', [{start}], 't', t(k), 'x', x(k), 'v', v(k));{empty.replace("        ", "            ")}
        else
            if ~(t(k) > state.t)
                error('{name}:time', 't = %g s at sample %d does not come after %g s', t(k), k, state.t);
            end
            state.s = {prefix}advance(state.s, state.x, x(k), state.v, v(k), t(k) - state.t, p);
            state.t = t(k); state.x = x(k); state.v = v(k);
        end
        f(k) = {prefix}force(state.s, x(k), v(k), 0.0, p);{delayed}{kept}
    end
end"""


def _follow(tau: float) -> str:
    """The lines that let the acting input follow the command, straight between samples: `dampyr.models.input_lag`'s step."""
    return f"""
        acting = u(k);
        if ~isempty(state)
            dt = t(k) - state.t;
            rise = (u(k) - state.command)/dt*{number(tau)};
            acting = u(k) - rise + (state.acting - state.command + rise)*exp(-dt/{number(tau)});
        end"""


def _parameters(damper: Damper, prefix: str) -> str:
    lines = []
    for k, (key, law) in enumerate(damper.all_laws.items(), start=1):
        lines += [f"    % {key}", *_law(law, k, key)]
    count = len(damper.all_laws)
    u = "u" if damper.has_input else ""
    return "\n".join([f"function p = {prefix}parameters({u})", f"    p = zeros(1, {count});", *lines, "end"])


def _law(law: Law, k: int, key: str) -> list[str]:
    if isinstance(law, Constant):
        return [f"    p({k}) = {number(law.value)};"]
    if isinstance(law, Polynomial):
        text = number(law.coefficients[-1])
        for c in reversed(law.coefficients[:-1]):
            text = f"({number(c)} + u*{text})"
        return [f"    p({k}) = {text};"]
    if isinstance(law, Interpolation):
        rows = "; ".join(", ".join(number(c) for c in row) for row in law.pieces.T)
        knots = ", ".join(number(knot) for knot in law.knots[:-1])
        return [
            f"    knots = [{knots}]; c = [{rows}];",
            "    i = max([1, find(u >= knots, 1, 'last')]); w = u - knots(i);",
            f"    p({k}) = c(i, 1) + w*(c(i, 2) + w*(c(i, 3) + w*c(i, 4)));",
        ]
    raise InputError(f"the law of {key}, {law!r}, has no MATLAB form; choose constant, polynomial or interpolation")


def _late(prefix: str) -> str:
    """The delayed force, from all samples since the start."""
    return f"""\
function [f, state] = {prefix}late(state, f, tau)
    state.late_t(end + 1) = state.t;
    state.late_f(end + 1) = f;
    at = state.t - tau;
    if tau <= 0 || numel(state.late_t) == 1, return; end
    if at <= state.late_t(1), f = state.late_f(1); return; end
    i = find(state.late_t <= at, 1, 'last');
    part = (at - state.late_t(i))/(state.late_t(i + 1) - state.late_t(i));
    f = state.late_f(i)*(1.0 - part) + state.late_f(i + 1)*part;
    state.late_t = state.late_t(i:end);
    state.late_f = state.late_f(i:end);
end"""
