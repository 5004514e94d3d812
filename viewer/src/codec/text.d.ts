// Files that the bundler includes as text.

declare module "*.txt" {
  const text: string;
  export default text;
}
