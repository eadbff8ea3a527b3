/** The header that says who asks; none where nobody has said who. */
export const authorization = (token: string | null): Record<string, string> => (token ? { Authorization: `Bearer ${token}` } : {});
