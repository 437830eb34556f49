import { canvasAhead } from "./canvas_ahead";

// What the build puts in: the address of the worker's script (scripts/build.mjs).
declare const kToothWorkerAddress: string;

interface TrustedTypePolicies {
  createPolicy(
    name: string,
    rules: { createScriptURL: (address: string) => string },
  ): { createScriptURL(address: string): unknown };
}

// The server's Content-Security-Policy names this policy and no other (server/http/site.cpp), once:
// no other script can run as a worker, even on a page that was tampered with.
const kPolicyName = "enamel-worker";
let trusted: unknown;
function workerAddress(): string | URL {
  const policies = (globalThis as { trustedTypes?: TrustedTypePolicies }).trustedTypes;
  if (policies === undefined) return kToothWorkerAddress;
  trusted ??= policies.createPolicy(kPolicyName, { createScriptURL: onlyWorker }).createScriptURL(kToothWorkerAddress);
  return trusted as URL;
}
function onlyWorker(address: string): string {
  if (address !== kToothWorkerAddress) throw new TypeError(`only ${kToothWorkerAddress} runs as a worker`);
  return address;
}

// What draws teeth, and the canvas of the first.
export interface Drawer {
  readonly worker: Worker;
  readonly canvas: HTMLCanvasElement;
}

// Throws where the browser refuses workers, or such a canvas.
export function startWorker(): Drawer {
  const worker = new Worker(workerAddress(), { type: "module" });
  return { worker, canvas: canvasAhead(worker) };
}
