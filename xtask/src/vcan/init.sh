#!/bin/busybox sh
# The first program of the emulated PC of `cargo xtask vcan`.
/bin/busybox mkdir -p /sbin /usr/bin /usr/sbin /tmp/run
/bin/busybox --install -s
mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t devtmpfs dev /dev
export PATH=/bin:/sbin:/usr/bin:/usr/sbin HOME=/tmp XDG_RUNTIME_DIR=/tmp/run NO_COLOR=1
cd /project
result() { if [ "$2" = 0 ]; then echo "RESULT $1: ok"; else echo "RESULT $1: bad"; fi; }
# True if the file has every one of these texts.
has() { file=$1; shift; for text in "$@"; do grep -q -- "$text" "$file" || { echo "missing in $file: $text"; cat "$file"; return 1; }; done; }

newtau motors scan --can vcan0 > /tmp/none.txt 2>&1
[ $? = 1 ] && has /tmp/none.txt vcan0
result "no interface" $?

for module in can can-raw can-dev vcan; do insmod /modules/$module.ko || echo "no module $module"; done
ip link add dev vcan0 type vcan
ip link set vcan0 up

# Slow enough for an emulated processor.
sed -e 's/rate = 400/rate = 50/' -e 's/natural_frequency = 40.0/natural_frequency = 10.0/' scenes/yam_one_bus.toml > scenes/slow.toml
vcan-arm scenes/slow.toml vcan0 > /tmp/arm.txt 2>&1 &
arm=$!
while ! grep -q "the arm is at" /tmp/arm.txt; do sleep 1; done

newtau motors scan --can vcan0 > /tmp/scan.txt 2>&1
[ $? = 0 ] && has /tmp/scan.txt damiao
result scan $?

printf 'home\nconfirm\narm\nfull-range\njog wrist_roll 0.2 2\nwait\nstatus\npark\n' > /tmp/session.txt
newtau drive scenes/slow.toml --can vcan0 --script /tmp/session.txt > /tmp/out.txt 2>&1
[ $? = 0 ] && has /tmp/out.txt "arm: armed" "wait: arrived" "park: " " 0 ended too late"
result session $?

# An arm that is held until something happens to it.
hold() { printf 'home\nconfirm\narm\nfull-range\ngoto 0 0.6 0.8 0 0 0 3\nwait\nwait 60\n' > /tmp/hold.txt
  newtau drive scenes/slow.toml --can vcan0 --script /tmp/hold.txt > /tmp/out.txt 2>&1 &
  held=$!
  while ! grep -q "wait: arrived" /tmp/out.txt; do sleep 1; kill -0 $held || { cat /tmp/out.txt; break; }; done; }

hold
newtau drive scenes/slow.toml --can vcan0 --script /tmp/session.txt > /tmp/second.txt 2>&1
[ $? = 1 ] && has /tmp/second.txt "another newtau uses this interface"
result "second program" $?
ip link set vcan0 down
wait $held
[ $? = 3 ] && has /tmp/out.txt fault
result "interface down" $?

# The arm's socket saw the interface go down, too.
kill $arm; wait $arm
ip link set vcan0 up
vcan-arm scenes/slow.toml vcan0 > /tmp/arm.txt 2>&1 &
while ! grep -q "the arm is at" /tmp/arm.txt; do sleep 1; done
hold
kill -9 $held
# Afterwards the interface is free, and the drives' own timeouts have switched them off.
sleep 2
newtau drive scenes/slow.toml --can vcan0 --script /tmp/session.txt > /tmp/out.txt 2>&1
[ $? = 0 ] && has /tmp/out.txt "wait: arrived"
result killed $?
poweroff -f
