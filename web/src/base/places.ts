// How far down a page was scrolled at each address of the browser's history, so that going back returns there.

// An entry of the history, by a number of its own.
export class Places {
  private readonly tops = new Map<number, number>();
  private next: number;

  constructor(private current: number) {
    this.next = current + 1;
  }

  // The page is at `top` now.
  seen(top: number): void {
    this.tops.set(this.current, top);
  }
  // A new entry, whose number the history keeps.
  opened(): number {
    this.current = this.next++;
    return this.current;
  }
  // Back or on to that entry: where it was.
  returned(entry: number): number {
    this.current = entry;
    this.next = Math.max(this.next, entry + 1);
    return this.tops.get(entry) ?? 0;
  }
}
