// Where mesial is in a scene's frame: 1, along +x, or -1, along -x. By the quadrant of the tooth's FDI
// number; a practice block, which is no tooth (null), has it at +x.
export type MesialX = 1 | -1;

export function mesialX(tooth: number | null): MesialX {
  return tooth !== null && Math.floor(tooth / 10) % 2 === 0 ? -1 : 1;
}
