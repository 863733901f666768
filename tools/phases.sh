#!/bin/sh
# Run targets one after the other and print the time of each: phases.sh MAKE TARGET...
# All targets run even if one fails; the exit code is then 1.
set -u
make=$1
shift
failed=0
table=

for target in "$@"; do
    printf '\n==== make %s\n' "$target"
    start=$(date +%s)
    if $make --keep-going "$target"; then result=passed; else result=FAILED; failed=1; fi
    seconds=$(($(date +%s) - start))
    table="$table$(printf '  %-12s %s in %d s' "$target" "$result" "$seconds")
"
done

printf '\n==== phases\n%s' "$table"
exit "$failed"
