// For what can only be wrong through a mistake of ours; input errors are Results.
export function check(condition: boolean, message: string): asserts condition {
  if (!condition) throw new Error(`assertion failed: ${message}`);
}

export function unreachable(value: never): never {
  throw new Error(`unexpected value: ${String(value)}`);
}
