// Answers of the mock server, and what many of its handlers need.
export const json = (value, status = 200, headers = {}) =>
  ({ status, body: JSON.stringify(value), headers: { "Content-Type": "application/json", "Cache-Control": "no-store", ...headers } });
export const empty = () => ({ status: 204 });
export const refusal = (status, code, message, field = "") => json({ error: { code, message, field } }, status);
export const notFound = () => refusal(404, "not_found", "There is no such thing.");
export const forbidden = () => refusal(403, "forbidden", "Only somebody with another role may do that.");
export const invalid = (field, message) => refusal(400, "invalid_input", message, field);
export const conflict = (message) => refusal(409, "conflict", message);
export const tagged = (value, status = 200) => json(value, status, { ETag: `"${value.revision}"` });

// One page of rows; the cursor is where it begins.
export function page(name, rows, query, otherwise = 50) {
  const first = Number(query.get("cursor") ?? 0);
  const limit = Number(query.get("limit") ?? otherwise);
  const next = first + limit < rows.length ? String(first + limit) : null;
  return json({ [name]: rows.slice(first, first + limit), next });
}

// The refusal when the caller has not seen the row as it is now.
export function unseen(request, row, view) {
  const seen = request.headers["if-match"];
  if (seen === undefined) return refusal(428, "precondition_required", "Send If-Match with the ETag you have read.", "if-match");
  if (seen !== `"${row.revision}"`) {
    return json({ error: { code: "precondition_failed", message: "Somebody changed it meanwhile; read it again.", field: "revision" }, current: view(row) }, 412,
                { ETag: `"${row.revision}"` });
  }
  return undefined;
}

// Carries out `change` when the caller has seen the row as it is now.
export function edit(request, row, view, change) {
  const refused = unseen(request, row, view) ?? change(row);
  if (refused !== undefined) return refused;
  row.revision += 1;
  return tagged(view(row));
}
