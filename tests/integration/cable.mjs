// cable.mjs LISTEN_PORT SERVER_PORT CUT_FILE: carries connections to a server on loopback; while CUT_FILE is there it cuts
// all of them at random moments, 50 to 600 ms apart, some in the middle of what was being carried. Prints each ten cuts.
import { existsSync } from "node:fs";
import net from "node:net";

const [listen, server, cutFile] = [Number(process.argv[2]), Number(process.argv[3]), process.argv[4]];
const open = new Set();
let cuts = 0;

net.createServer((station) => {
  const far = net.connect(server, "127.0.0.1");
  for (const [from, to] of [[station, far], [far, station]]) {
    open.add(from);
    from.on("data", (bytes) => {
      // The cable breaks in the middle of a packet: half of it arrives.
      if (existsSync(cutFile) && Math.random() < 0.02) to.write(bytes.subarray(0, bytes.length >> 1), () => { station.destroy(); far.destroy(); });
      else to.write(bytes);
    });
    from.on("error", () => {});
    from.on("close", () => { open.delete(from); to.destroy(); });
  }
}).listen(listen, "127.0.0.1", () => console.log("ready"));

const next = () => setTimeout(() => {
  if (existsSync(cutFile) && open.size > 0) {
    for (const socket of open) socket.destroy();
    if (++cuts % 10 === 0) console.log(`${cuts} cuts`);
  }
  next();
}, 50 + Math.random() * 550);
next();
