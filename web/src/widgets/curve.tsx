const kWidth = 120;
const kHeight = 28;
const kInset = 4;

// Shares of what was to be had, 0..1, oldest first. `label`: the same in words.
export function Curve({ shares, label }: { readonly shares: readonly number[]; readonly label: string }) {
  const x = (i: number) =>
    shares.length === 1 ? kWidth / 2 : kInset + ((kWidth - 2 * kInset) * i) / (shares.length - 1);
  const y = (share: number) => kHeight - kInset - (kHeight - 2 * kInset) * share;
  return (
    <svg class="curve" viewBox={`0 0 ${kWidth} ${kHeight}`} role="img" aria-label={label}>
      <line x1="0" x2={kWidth} y1={y(1)} y2={y(1)} />
      <polyline points={shares.map((share, i) => `${x(i)},${y(share)}`).join(" ")} />
      <circle cx={x(shares.length - 1)} cy={y(shares.at(-1) ?? 0)} r="3" />
    </svg>
  );
}
