#!/usr/bin/env bash
# The one step of the action: compares, judges, tells the runner. Inputs come as INPUT_*, so that no name is ever read as a script.
# The exit code is the program's, but for `report-only`, where an open or failed verdict is 0.
set -euo pipefail

paths="${INPUT_PATHS-datasets}"
bounds="${INPUT_BOUNDS-}"
baseline="${INPUT_BASELINE-}"
out="${INPUT_OUT-report}"
report_only="${INPUT_REPORT_ONLY-false}"
binary="${INPUT_BINARY-pneuval}"
upload="${INPUT_UPLOAD-true}"

temporary="${RUNNER_TEMP:-${TMPDIR:-/tmp}}"
scratch="$(mktemp -d "$temporary/pneuval.XXXXXX")"
trap 'rm -rf -- "$scratch"' EXIT
: >"$scratch/annotations"
: >"$scratch/told"

# Nobody who writes a file name can guess this word.
secret() { od -An -N16 -tx1 /dev/urandom | tr -d ' \n'; }

# One output of the step, whatever is in it.
output() { # NAME VALUE
    local end
    end="end-$(secret)"
    printf '%s<<%s\n%s\n%s\n' "$1" "$end" "$2" "$end" >>"${GITHUB_OUTPUT:-/dev/null}"
}

# The text of an annotation, as the runner wants it escaped.
escaped() { # TEXT
    local text="${1//\%/%25}"
    text="${text//$'\r'/%0D}"
    printf '%s' "${text//$'\n'/%0A}"
}

# A summary may have 1 MiB; a longer one would not be shown at all.
summarise() { # FILE
    local summary="${GITHUB_STEP_SUMMARY:-/dev/null}"
    if [ "$(wc -c <"$1")" -le 1000000 ]; then
        cat -- "$1" >>"$summary"
    else
        head -c 1000000 -- "$1" | sed '$d' >>"$summary"
        printf '\nCut here; the report has all of it.\n' >>"$summary"
    fi
}

# What the program said beside its results. A file name in it may look like a command to the runner: it is not to be obeyed.
tell() { # FILE
    [ -s "$1" ] || return 0
    local word
    word="$(secret)"
    printf '::stop-commands::%s\n' "$word"
    cat -- "$1"
    printf '\n::%s::\n' "$word"
}

# Runs the program; its exit code goes to `code`, its results to a file, its diagnostics to "$scratch/told".
code=0
program() { # FILE ARGUMENT..
    local file="$1"
    shift
    code=0
    "$binary" "$@" >"$file" 2>"$scratch/told" || code=$?
}

# No decision: annotation, summary, outputs, and the exit code.
stop() { # CODE REPORT
    local text decision
    text="$(head -c 20000 "$scratch/told")"
    [ -n "$text" ] || text="error: $binary ended with exit code $1"
    decision="$(grep -m 1 '^error' <<<"$text" || head -n 1 <<<"$text")"
    tell "$scratch/told"
    printf '::error title=pneuval::%s\n' "$(escaped "$text")"
    # shellcheck disable=SC2001 # one line after the other
    { printf '## pneuval: no decision (exit code %s)\n\n' "$1" && sed 's/^/    /' <<<"$text"; } >"$scratch/summary"
    summarise "$scratch/summary"
    output exit-code "$1"
    output decision "${decision//$'\r'/ }"
    output report "$2"
    output junit ''
    exit "$1"
}

# An input that only this script can judge.
refuse() { # NAME EXPECTED FOUND
    # shellcheck disable=SC2016 # these are quotes, not commands
    printf 'error: input `%s`\n  expected: %s\n  found:    `%s`\n' "$1" "$2" "$3" >"$scratch/told"
    stop 2 ''
}

case "$report_only" in true | false) ;; *) refuse report-only 'true or false' "$report_only" ;; esac
case "$upload" in true | false) ;; *) refuse upload 'true or false' "$upload" ;; esac
command -v -- "$binary" >/dev/null || refuse binary 'a program on the PATH, or the path of one' "$binary"

data=()
while IFS= read -r line || [ -n "$line" ]; do
    line="${line%$'\r'}"
    [ -z "$line" ] || data+=("$line")
done <<<"$paths"
# Without a path the program validates the papers it holds: a gate that nobody asked for would be open.
[ "${#data[@]}" -gt 0 ] || refuse paths 'a dataset, a session, or a folder of them' ''

options=("--out=$out" --format=github)
[ -z "$bounds" ] || options+=("--bounds=$bounds")
[ "$report_only" = false ] || options+=(--report-only)
program "$scratch/annotations" validate "${options[@]}" -- "${data[@]}"
case "$code" in 0 | 1 | 3) ;; *) stop "$code" '' ;; esac
tell "$scratch/told"

# A leading dash would be an option to the next commands.
case "$out" in -*) report="./$out" ;; *) report="$out" ;; esac
summary="$report/results/summary.md"
junit="$report/results/junit.xml"

# The verdict without regard to `report-only`, from the stored numbers.
[ "$report_only" = false ] || program "$scratch/verdict" gate "$report"
verdict="$code"
case "$verdict" in 0 | 1 | 3) ;; *) stop "$verdict" "$report" ;; esac

if [ -n "$baseline" ]; then
    program "$scratch/annotations" gate "--baseline=$baseline" --format=github -- "$report"
    case "$code" in 0 | 1 | 3) ;; *) stop "$code" "$report" ;; esac
    judged="$code"
    summary="$scratch/summary"
    program "$summary" gate "--baseline=$baseline" --format=markdown -- "$report"
    if [ "$report_only" = true ]; then
        # Whoever only reports wants no red marks.
        sed -i.red 's/^::error /::warning /' "$scratch/annotations"
        printf '\nOnly reported: the step does not fail, whatever the verdicts.\n' >>"$summary"
    else
        # Beside the report: a report holds nothing that `validate` did not write.
        junit="$(mktemp -d "$temporary/pneuval-junit.XXXXXX")/junit.xml"
        program "$junit" gate "--baseline=$baseline" --format=junit -- "$report"
    fi
    code="$judged"
fi

cat -- "$scratch/annotations"
summarise "$summary"

# The last annotation is the decision.
decision="$(tail -n 1 "$scratch/annotations")"
decision="${decision#::notice title=pneuval::}"
decision="${decision//\%0A/ }"
decision="${decision//\%0D/ }"
decision="${decision//\%25/%}"
[ "$code" = "$verdict" ] || decision="$decision · worse than the baseline"

output exit-code "$code"
output decision "$decision"
output report "$report"
output junit "$junit"

[ "$report_only" = false ] || exit 0
exit "$code"
