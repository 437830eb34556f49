// The programs of a school: enamel-server and enamel-station of build/release, or of ENAMEL_BIN.
import { execFile, spawn } from "node:child_process";
import { createServer } from "node:net";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";

const run = promisify(execFile);
export const kPrograms =
  process.env.ENAMEL_BIN ?? fileURLToPath(new URL("../../../build/release/bin", import.meta.url));
const kMaxMs = 300_000; // of one command
const kMaxBytes = 1 << 24; // that it says
const kStartMs = 60_000;

function listening(port) {
  return new Promise((resolve) => {
    const server = createServer();
    server.once("error", () => resolve(undefined));
    server.listen(port, "127.0.0.1", () => resolve(server));
  });
}

// Two neighbours: page and station link.
export async function freePorts() {
  for (;;) {
    const one = await listening(0);
    const { port } = one.address();
    const two = await listening(port + 1);
    one.close();
    two?.close();
    if (two !== undefined) return port;
  }
}

// Runs a program to its end. `input` is what it reads. Throws with what it said where it fails.
export async function program(name, args, { input, environment = {}, mostMs = kMaxMs } = {}) {
  const running = run(join(kPrograms, name), args, {
    env: { ...process.env, ...environment },
    timeout: mostMs,
    maxBuffer: kMaxBytes,
  });
  running.child.stdin.end(input);
  try {
    return (await running).stdout;
  } catch (error) {
    throw new Error(`${name} ${args.join(" ")}: ${error.stderr ?? error.message}`);
  }
}

// A program that runs until somebody ends it, or this process ends.
export function spawned(name, args, environment = {}) {
  const child = spawn(join(kPrograms, name), args, {
    stdio: ["ignore", "pipe", "pipe"],
    env: { ...process.env, ...environment },
  });
  const kill = () => child.kill("SIGKILL");
  process.once("exit", kill);
  child.once("exit", () => process.off("exit", kill));
  return child;
}

// Once it has ended by itself, with exit code 0.
export async function exited(child) {
  if (child.exitCode === null) await new Promise((resolve) => child.once("exit", resolve));
  if (child.exitCode !== 0) throw new Error(`${child.spawnargs.join(" ")} ended with ${child.exitCode}`);
}

export async function ended(child, signal = "SIGTERM") {
  if (child === undefined || child.exitCode !== null || child.signalCode !== null) return;
  const gone = new Promise((resolve) => {
    child.once("exit", resolve);
  });
  child.kill(signal);
  await gone;
}

// `serve` on two free ports of loopback, once it is ready: { url, link, child, said }. `said()`: the
// last of what it has printed.
export async function startedServer(data, dist, ...more) {
  const port = await freePorts();
  const link = `127.0.0.1:${port + 1}`;
  const args = ["serve", "--data", data, "--http", `127.0.0.1:${port}`, "--stations", link, "--web", dist, ...more];
  const child = spawned("enamel-server", args);
  let said = "";
  const heard = (text) => {
    said = (said + text).slice(-20_000);
  };
  child.stderr.on("data", heard);
  await new Promise((resolve, reject) => {
    const timer = setTimeout(() => {
      child.kill("SIGKILL");
      reject(new Error(`the server is not ready after ${kStartMs} ms: ${said}`));
    }, kStartMs);
    child.once("exit", (code) => reject(new Error(`the server ended with ${code}: ${said}`)));
    child.stdout.on("data", (text) => {
      heard(text);
      if (!/^ready/m.test(said)) return;
      clearTimeout(timer);
      resolve();
    });
  });
  return { url: `http://127.0.0.1:${port}`, link, child, said: () => said };
}
