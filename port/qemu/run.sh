#!/bin/sh
# Runs an image on an emulated target; its output and exit status come back.
#
#   sh run.sh TARGET IMAGE [QEMU OPTION...]
#
# A fault ends an Arm image with 1 or 134, and hangs a RISC-V one: RIGCAL_TIMEOUT
# seconds (default 14400) end that. On an idle machine the longest test takes 5 minutes.
set -eu
target=$1
image=$2
shift 2

case $target in
cortex-m0)  machine="qemu-system-arm -M microbit" ;;
cortex-m4f) machine="qemu-system-arm -M mps2-an386" ;;
cortex-m7)  machine="qemu-system-arm -M mps2-an500" ;;
cortex-m33) machine="qemu-system-arm -M mps2-an505" ;;
# This core has no FPU either, so an image that needs one fails.
rv32imac)   machine="qemu-system-riscv32 -M virt -bios none -cpu rv32,f=false,d=false" ;;
rv32imafc)  machine="qemu-system-riscv32 -M virt -bios none -cpu rv32,d=false" ;;
mips)       exec timeout "${RIGCAL_TIMEOUT:-14400}" qemu-mips "$@" "$image" ;;
*)          echo "run.sh: there is no target $target" >&2; exit 2 ;;
esac

# shellcheck disable=SC2086 -- a command and its options
exec timeout "${RIGCAL_TIMEOUT:-14400}" $machine -display none -monitor none \
    -serial none -chardev stdio,id=console \
    -semihosting-config "enable=on,target=native,chardev=console,arg=$image" \
    "$@" -kernel "$image" </dev/null
