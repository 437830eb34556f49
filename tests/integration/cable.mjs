// cable.mjs LISTEN_PORT SERVER_PORT CUT_FILE [HOLD_FILE]: carries connections to a server on loopback; while CUT_FILE is there each of
// them breaks once it has carried a random 6 to 24 kB, both ways counted, in the middle of what was being carried. So how
// often it breaks depends on what is carried and not on how fast the computer is. Prints the number of cuts after each.
// While HOLD_FILE is there nothing that the server says comes through: to the station it is silent, and has not hung up.
import { existsSync } from "node:fs";
import net from "node:net";

const [listen, server] = [Number(process.argv[2]), Number(process.argv[3])];
const [cutFile, holdFile] = process.argv.slice(4);
let cuts = 0;

net.createServer((station) => {
  const far = net.connect(server, "127.0.0.1");
  let left = 6_000 + Math.random() * 18_000;
  const cut = () => {
    if (station.destroyed && far.destroyed) return;
    station.destroy();
    far.destroy();
    console.log(`${++cuts} cuts`);
  };
  for (const [from, to] of [[station, far], [far, station]]) {
    from.on("data", (bytes) => {
      if (left <= 0 || (from === far && holdFile && existsSync(holdFile))) return;
      const before = left;
      if (existsSync(cutFile)) left -= bytes.length;
      if (left > 0) to.write(bytes);
      else to.write(bytes.subarray(0, before), cut);
    });
    from.on("error", () => {});
    from.on("close", () => to.destroy());
  }
}).listen(listen, "127.0.0.1", () => console.log("ready"));
