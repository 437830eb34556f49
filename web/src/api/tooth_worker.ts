import { type ToothAsk, type ToothTold, ToothWork } from "./tooth_work";

// What runs in the worker that reads playbacks; a script of its own (scripts/build.mjs).

interface Scope {
  onmessage: ((event: MessageEvent<ToothAsk>) => void) | null;
  postMessage(message: ToothTold, transfer: readonly ArrayBuffer[]): void;
}
const scope = globalThis as unknown as Scope;

// A timer would wait for some milliseconds; a message of its own comes after those that wait
// already.
const channel = new MessageChannel();
let resume: (() => void) | undefined;
channel.port1.onmessage = () => resume?.();
const pause = () =>
  new Promise<void>((resolve) => {
    resume = resolve;
    channel.port2.postMessage(undefined);
  });

const work = new ToothWork((told, transfer) => scope.postMessage(told, transfer), pause);
scope.onmessage = ({ data }) => void work.take(data);
