import { apiAddress, type Fetch, fill, type RequestOptions, requestInit } from "./request_init";

// Of a timeline: the coarse tooth of every attempt that was looked at, and the fine one of most class I cavities.
export const kFirstBytes = 65_536;

// Answers to requests that were sent before anybody wanted them. Each is given out once.
export class Ahead {
  private readonly answers = new Map<string, Promise<Response>>(); // by path and range

  ask(send: Fetch, path: string, options: RequestOptions = {}): void {
    const answer = send(apiAddress(path), requestInit("GET", options));
    answer.catch(() => undefined); // whoever wants it is told
    this.answers.set(keyOf(path, options), answer);
  }
  take(path: string, options: RequestOptions): Promise<Response> | undefined {
    const key = keyOf(path, options);
    const answer = this.answers.get(key);
    this.answers.delete(key);
    return answer;
  }
  forgotten = false; // what was begun with these answers is no longer for anybody here

  // What was asked for belongs to somebody who is not here any more.
  forget(): void {
    this.answers.clear();
    this.forgotten = true;
  }
}

const keyOf = (path: string, { range }: RequestOptions) => `${path} ${range?.join("-") ?? ""}`;

// What will be wanted first: the session, and the tooth, where an attempt is to be shown. Each answer takes as long as
// the network is long, so all are asked for at once.
export function askFirst(ahead: Ahead, send: Fetch, attempt: string | undefined): void {
  ahead.ask(send, "/session");
  if (attempt === undefined) return;
  const of = (path: string) => fill(path, { id: attempt });
  ahead.ask(send, of("/attempts/{id}"));
  ahead.ask(send, of("/attempts/{id}/timeline"), { range: [0, kFirstBytes], kept: true });
  ahead.ask(send, of("/attempts/{id}/score"), { kept: true });
}
