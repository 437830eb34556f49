import { fail, type Result } from "../base/result";
import type { FramePose, Head } from "./timeline";
import type { BlockMesh } from "./tooth_mesh";
import type { Compared, Extent, ToothAsk, ToothTold } from "./tooth_work";

// The page's end of what reads playbacks (tooth_work.ts). The page's thread only hands bytes over
// and gets triangles.

// A worker, or what stands for one.
export interface ToothPort {
  postMessage(asked: ToothAsk, transfer: ArrayBuffer[]): void;
  onmessage: ((event: { readonly data: ToothTold }) => void) | null;
  onerror: ((event: { readonly message?: string }) => void) | null;
  terminate(): void;
}

export interface ToothWatcher {
  blocks(blocks: readonly (readonly [number, BlockMesh | undefined])[]): void;
  shown(frames: number, cut: Extent | undefined): void;
  failed(message: string): void;
}

// Requests that have an answer, which comes back under the same name.
type Answers = {
  head: Result<Head, string>;
  coarse: Result<Extent, string>;
  start: Result<Extent, string>;
  segment: Result<readonly FramePose[], string>;
  deviation: Result<Compared, string>;
};

export class ToothLink {
  private nextId = 0;
  private readonly waiting = new Map<number, (answer: Answers[keyof Answers]) => void>();

  constructor(
    private readonly port: ToothPort,
    private readonly watcher: ToothWatcher,
  ) {
    port.onmessage = ({ data }) => this.told(data);
    port.onerror = () => this.lost("what reads it could not be loaded or has stopped: load the page again");
  }

  // Afterwards nothing is reported, and open requests get no answer.
  dispose(): void {
    this.port.onmessage = this.port.onerror = null;
    this.port.terminate();
    this.waiting.clear();
  }

  // The bytes are handed over: whoever gave them has them no longer.
  head(bytes: ArrayBuffer): Promise<Answers["head"]> {
    return this.ask((id) => ({ ask: "head", id, bytes }), bytes);
  }
  // Shown until the first fine picture.
  coarse(bytes: ArrayBuffer): Promise<Answers["coarse"]> {
    return this.ask((id) => ({ ask: "coarse", id, bytes }), bytes);
  }
  start(bytes: ArrayBuffer): Promise<Answers["start"]> {
    return this.ask((id) => ({ ask: "start", id, bytes }), bytes);
  }
  segment(index: number, bytes: ArrayBuffer): Promise<Answers["segment"]> {
    return this.ask((id) => ({ ask: "segment", id, index, bytes }), bytes);
  }
  // After start and last segment.
  deviation(bytes: ArrayBuffer): Promise<Answers["deviation"]> {
    return this.ask((id) => ({ ask: "deviation", id, bytes }), bytes);
  }
  // The latest wish counts. Where that part is not here yet it is fulfilled when it is.
  seek(frames: number): void {
    this.port.postMessage({ ask: "seek", frames }, []);
  }

  private ask<T extends Answers[keyof Answers]>(message: (id: number) => ToothAsk, bytes: ArrayBuffer): Promise<T> {
    const id = this.nextId++;
    return new Promise((resolve) => {
      this.waiting.set(id, resolve as (answer: Answers[keyof Answers]) => void);
      this.port.postMessage(message(id), [bytes]);
    });
  }

  private told(told: ToothTold): void {
    switch (told.told) {
      case "blocks":
        return this.watcher.blocks(told.blocks);
      case "shown":
        return this.watcher.shown(told.frames, told.cut);
      case "failed":
        return this.watcher.failed(told.message);
      case "head":
        return this.answer(told.id, told.head);
      case "coarse":
      case "start":
        return this.answer(told.id, told.extent);
      case "segment":
        return this.answer(told.id, told.poses);
      case "deviation":
        return this.answer(told.id, told.compared);
    }
  }
  private answer(id: number, answer: Answers[keyof Answers]): void {
    const resolve = this.waiting.get(id);
    this.waiting.delete(id);
    resolve?.(answer);
  }
  private lost(message: string): void {
    for (const id of [...this.waiting.keys()]) this.answer(id, fail(message));
    this.watcher.failed(message);
  }
}

// What the build puts in: the address of the worker's script, whose name changes with its content.
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

// Throws where the browser refuses workers.
export function startToothWorker(): ToothPort {
  return new Worker(workerAddress(), { type: "module" }) as unknown as ToothPort;
}
