// Keeps at most `most` of many streams open, each in turn: browsers allow only a few connections to
// one server at a time, and the page needs some for its other requests.
export class Rotation {
  private readonly open = new Map<string, () => void>(); // oldest first
  private ids: readonly string[] = [];
  private next = 0;

  constructor(
    private readonly most: number,
    private readonly start: (id: string) => () => void,
  ) {}

  // Follows these ids: closes streams of all others and fills free places at once.
  follow(ids: readonly string[]): void {
    this.ids = ids;
    for (const id of [...this.open.keys()]) if (!ids.includes(id)) this.stop(id);
    while (this.open.size < Math.min(this.most, ids.length)) this.startNext();
  }

  // Gives the place of the one that was followed longest to the next in line. Without effect while
  // all have a place.
  turn(): void {
    const oldest = this.open.keys().next().value;
    if (oldest === undefined || this.ids.length <= this.open.size) return;
    this.stop(oldest);
    this.startNext();
  }

  dispose(): void {
    for (const id of [...this.open.keys()]) this.stop(id);
    this.ids = [];
  }

  private startNext(): void {
    for (let tried = 0; tried < this.ids.length; ++tried) {
      const id = this.ids[this.next++ % this.ids.length]!;
      if (this.open.has(id)) continue;
      this.open.set(id, this.start(id));
      return;
    }
  }

  private stop(id: string): void {
    this.open.get(id)?.();
    this.open.delete(id);
  }
}
