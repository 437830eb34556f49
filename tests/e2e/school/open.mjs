// A school for the browser flows, on a server and behind a proxy of their own.
import { cpSync, existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { until } from "../../contract/client.mjs";
import { startProxy } from "../proxy.mjs";
import { ended, program, spawned, startedServer } from "./programs.mjs";

// Where make.mjs puts it unless told otherwise.
export const kSchool = fileURLToPath(new URL("../../../build/release/school", import.meta.url));
export const kChairs = ["Chair 1", "Chair 2"];

// `folder`: what make.mjs made; it is only read. { url, school, proxy, data, link, fresh, restart, empty, attempt,
// close }.
// `fresh()` puts the school back as it was made, where anybody has changed it. `restart(options)`: the same data
// behind a server with more options of `serve`. `attempt(chair, login, exercise, operator, …)`: enamel-station makes one
// in real time, until it is done or `fresh` ends it. `stream(stations, minutes)`: so many stations of enamel-loadgen
// record at once. `handIn(chair, child)`: ends it as it is, and sends the end. `empty()`: a new server instead, and what it has printed.
export async function openSchool({ folder, dist }) {
  const text = join(folder, "school.json");
  if (!existsSync(text)) throw new Error(`expected a school in ${folder}: node tests/e2e/school/make.mjs makes one`);
  const proxy = await startProxy();
  const work = mkdtempSync(join(tmpdir(), "enamel-school-"));
  const opened = { url: proxy.url, proxy, school: JSON.parse(readFileSync(text, "utf8")), data: join(work, "data") };
  let server;
  const running = [];
  const start = async (...more) => {
    server = await startedServer(opened.data, dist, ...more);
    proxy.target = server.url;
    opened.link = server.link;
  };
  const renew = async () => {
    for (const child of [...running.splice(0), server?.child]) await ended(child, "SIGKILL");
    for (const part of ["data", ...kChairs]) {
      rmSync(join(work, part), { recursive: true, force: true });
      cpSync(join(folder, part), join(work, part), { recursive: true });
    }
    proxy.changed = false;
    await start();
  };
  await renew();
  return Object.assign(opened, {
    fresh: async () => {
      proxy.faults = [];
      if (proxy.changed) await renew();
    },
    restart: async (...more) => {
      const release = proxy.hold(); // a page that asks meanwhile waits
      await ended(server.child);
      proxy.changed = true; // the next flow has the usual options again
      await start(...more).finally(release);
    },
    empty: async () => {
      await ended(server.child);
      rmSync(opened.data, { recursive: true });
      proxy.changed = true;
      await start();
      await until("the link of the first admin", () => server.said().includes("first admin"));
      return server.said();
    },
    attempt: (chair, login, exercise, operator, ...more) => {
      const args = ["run", "--data", join(work, chair), "--server", opened.link, "--profile", "phantom_desktop"];
      args.push("--quiet", "--user", login, "--exercise", exercise, "--operator", operator, ...more);
      running.push(spawned("enamel-station", args, { ENAMEL_PASSWORD: opened.school.people[login].password }));
      proxy.changed = true;
      return running.at(-1);
    },
    stream: (stations, minutes) => {
      const args = [
        "--stations",
        `${stations}`,
        "--minutes",
        `${minutes}`,
        "--server",
        opened.link,
        "--data",
        opened.data,
      ];
      running.push(spawned("enamel-loadgen", args));
      proxy.changed = true;
    },
    handIn: async (chair, child) => {
      await ended(child); // left, to be continued
      const place = ["--data", join(work, chair)];
      await program("enamel-station", ["spool", "close", "last", ...place]);
      await program("enamel-station", ["upload", ...place, "--server", opened.link]);
    },
    close: async () => {
      for (const child of [...running, server?.child]) await ended(child, "SIGKILL");
      await proxy.close();
      rmSync(work, { recursive: true, force: true });
    },
  });
}
