// Bodies and queries that a server has to refuse, made from the contract and one right body.

const kOfEveryType = [7, 0.5, "x y", true, [], {}, null];

const kindOf = (value) => (value === null ? "null" : Array.isArray(value) ? "array" : typeof value);

function* beyondBounds(shape, value) {
  if (shape.maxLength !== undefined && typeof value === "string") yield ["too long", "x".repeat(shape.maxLength + 1)];
  if (shape.minLength > 0 && typeof value === "string") yield ["empty", ""];
  if (shape.maximum !== undefined) yield ["too large", shape.maximum + 1];
  if (shape.minimum !== undefined) yield ["too small", shape.minimum - 1];
  if (shape.maxItems !== undefined && Array.isArray(value) && value.length > 0)
    yield ["too many", Array.from({ length: shape.maxItems + 1 }, () => value[0])];
}

// [what is wrong, the member, the body]
export function* wrongBodies(contract, schema, right) {
  const { type, properties, required } = contract.shapeOf(schema);
  if (type !== "object") return;
  if (Object.keys(properties).length === 0) {
    yield ["a list", "", [right]];
    return;
  }
  for (const name of required) {
    const { [name]: _, ...without } = right;
    yield ["missing", name, without];
  }
  for (const [name, of] of Object.entries(properties)) {
    for (const value of kOfEveryType)
      if (!contract.fits(of, value)) yield [`of type ${kindOf(value)}`, name, { ...right, [name]: value }];
    for (const [what, value] of beyondBounds(contract.shapeOf(of), right[name]))
      yield [what, name, { ...right, [name]: value }];
  }
  yield ["unknown", "nonsense", { ...right, nonsense: 1 }];
}

// [the parameter, its text]
export function* wrongQueries(contract, parameters) {
  for (const { name, schema } of parameters) {
    const shape = contract.shapeOf(schema);
    const integer = shape.type === "integer" || shape.type === "number";
    if (integer || shape.type === "boolean" || shape.enum || shape.format) yield [name, "x!"];
    if (integer && shape.maximum !== undefined) yield [name, String(shape.maximum + 1)];
    if (integer && shape.minimum !== undefined) yield [name, String(shape.minimum - 1)];
    if (shape.maxLength !== undefined) yield [name, "x".repeat(shape.maxLength + 1)];
  }
}
