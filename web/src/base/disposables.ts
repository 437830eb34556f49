// Clean-up steps collected while setting something up, run once in reverse order.
export class Disposables {
  private steps: Array<() => void> = [];

  add(step: () => void): void {
    this.steps.push(step);
  }

  listen(target: EventTarget, type: string, handler: (event: Event) => void, options?: AddEventListenerOptions): void {
    target.addEventListener(type, handler, options);
    this.add(() => target.removeEventListener(type, handler, options));
  }

  dispose(): void {
    const steps = this.steps.reverse();
    this.steps = [];
    for (const step of steps) step();
  }
}
