"""A record as a fit takes it."""
