export function BrandMark() {
  return (
    <svg class="brand-mark" viewBox="0 0 32 32" aria-hidden="true">
      <rect width="32" height="32" rx="8" />
      <path d="M10.2 7.2c2.2-1 3.9.5 5.8.5s3.6-1.5 5.8-.5c3.2 1.5 3.3 5.3 2.3 8.6-.8 2.5-1 4-1.3 6.3-.3 2-.9 3.4-2.2 3.4-2.7 0-1.6-7-4.6-7s-1.9 7-4.6 7c-1.3 0-1.9-1.4-2.2-3.4-.3-2.3-.5-3.8-1.3-6.3-1-3.3-.9-7.1 2.3-8.6z" />
    </svg>
  );
}
