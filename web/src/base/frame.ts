// Draws at most once per animation frame however often it is asked to: latest state wins.
export class FrameScheduler {
  private handle: number | undefined;

  constructor(private readonly draw: () => void) {}

  get requested(): boolean {
    return this.handle !== undefined;
  }
  request(): void {
    this.handle ??= requestAnimationFrame(() => {
      this.handle = undefined;
      this.draw();
    });
  }

  cancel(): void {
    if (this.handle !== undefined) cancelAnimationFrame(this.handle);
    this.handle = undefined;
  }
}
