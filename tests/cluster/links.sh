# Machines of their own for PostgreSQL, on one computer: network namespaces "one" and "two" of this script's namespace, with
# two links each: a (192.0.2.2, .10) for everybody, b (192.0.2.6, .14) for server one alone. A link that is down swallows
# packets and answers nothing, as a machine that is gone. Sourced by run.sh within `unshare --net --mount`; they end with it.
#   links_make          the namespaces, as root
#   links_tls FOLDER    a certificate for these addresses: FOLDER/pg.crt, pg.key
links_make() {
  local name side number=0
  ip link set lo up
  mkdir -p /run/netns
  mount -t tmpfs tmpfs /run/netns
  for name in one two; do
    ip netns add $name
    ip -n $name link set lo up
    for side in a b; do
      ip link add $name$side type veth peer name eth$side netns $name
      ip addr add 192.0.2.$((4 * number + 1))/30 dev $name$side
      ip -n $name addr add 192.0.2.$((4 * number + 2))/30 dev eth$side
      ip link set $name$side up
      ip -n $name link set eth$side up
      # Nobody asks who has the address: what is sent to a link that is down vanishes, as behind a router.
      ip neigh replace 192.0.2.$((4 * number + 2)) lladdr "$(ip netns exec $name cat /sys/class/net/eth$side/address)" dev $name$side nud permanent
      number=$((number + 1))
    done
  done
}
links_tls() {
  openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=database \
    -addext subjectAltName=IP:192.0.2.2,IP:192.0.2.6,IP:192.0.2.10,IP:192.0.2.14 -keyout "$1/pg.key" -out "$1/pg.crt" 2>/dev/null
}
